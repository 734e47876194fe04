#include "core/io/text/joint_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "core/base/error.h"

namespace kinegraph {
namespace {

struct Part {
  const char* squeezed;  // without separators, in small letters
  const char* name;
};

constexpr std::array<Part, 21> kSided = {{{"eye", "eye"},
                                          {"eyeinner", "eye_inner"},
                                          {"eyeouter", "eye_outer"},
                                          {"ear", "ear"},
                                          {"mouth", "mouth"},
                                          {"shoulder", "shoulder"},
                                          {"elbow", "elbow"},
                                          {"wrist", "wrist"},
                                          {"pinky", "pinky"},
                                          {"index", "index"},
                                          {"thumb", "thumb"},
                                          {"hip", "hip"},
                                          {"knee", "knee"},
                                          {"ankle", "ankle"},
                                          {"heel", "heel"},
                                          {"bigtoe", "big_toe"},
                                          {"smalltoe", "small_toe"},
                                          {"footindex", "foot_index"},
                                          {"toe", "big_toe"},
                                          {"foot", "ankle"},
                                          {"hand", "wrist"}}};

constexpr std::array<Part, 14> kCentral = {{{"nose", "nose"},
                                            {"neck", "neck"},
                                            {"head", "head_top"},
                                            {"headtop", "head_top"},
                                            {"tophead", "head_top"},
                                            {"forehead", "head_top"},
                                            {"headbottom", "head_bottom"},
                                            {"hip", "mid_hip"},
                                            {"midhip", "mid_hip"},
                                            {"chip", "mid_hip"},
                                            {"pelvis", "mid_hip"},
                                            {"hips", "mid_hip"},
                                            {"root", "mid_hip"},
                                            {"chin", "head_bottom"}}};

template <size_t kCount>
const char* Find(const std::array<Part, kCount>& parts,
                 const std::string& squeezed) {
  for (const Part& part : parts) {
    if (squeezed == part.squeezed) return part.name;
  }
  return nullptr;
}

std::string Squeezed(const std::string& label) {
  std::string squeezed;
  for (const char c : label) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) {
      squeezed += static_cast<char>(std::tolower(byte));
    }
  }
  return squeezed;
}

bool Strip(const std::string& text, const std::string& end, bool at_front,
           std::string* rest) {
  if (text.size() <= end.size()) return false;
  const size_t at = at_front ? 0 : text.size() - end.size();
  if (text.compare(at, end.size(), end) != 0) return false;
  *rest = at_front ? text.substr(end.size()) : text.substr(0, at);
  return true;
}

// "LBigToe" for l_big_toe.
std::string CamelCase(const std::string& joint) {
  std::string text;
  bool begins = true;
  for (const char c : joint) {
    if (c == '_') {
      begins = true;
      continue;
    }
    text += begins
                ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
                : c;
    begins = false;
  }
  return text;
}

}  // namespace

std::string JointNameOf(const std::string& label) {
  const std::string squeezed = Squeezed(label);
  if (const char* name = Find(kCentral, squeezed)) return name;
  std::string part;
  // Whole words first: "left_ear" must not become "l" and "eftear".
  for (const auto& [word, side] :
       {std::pair{"left", "l_"}, {"right", "r_"}, {"l", "l_"}, {"r", "r_"}}) {
    for (const bool at_front : {true, false}) {
      if (!Strip(squeezed, word, at_front, &part)) continue;
      if (const char* name = Find(kSided, part)) {
        return side + std::string(name);
      }
    }
  }
  // Points without a name of their own, as those of a face: "left_face_3".
  for (const auto& [word, side] :
       {std::pair{"left_", "l_"}, {"right_", "r_"}}) {
    if (Strip(label, word, /*at_front=*/true, &part)) return side + part;
  }
  return label;
}

std::string LongJointName(const std::string& joint) {
  const bool left = joint.compare(0, 2, "l_") == 0;
  const bool right = joint.compare(0, 2, "r_") == 0;
  if (!left && !right) return joint;
  const std::string side = left ? "left" : "right";
  const std::string part = joint.substr(2);
  return part == "mouth" ? part + "_" + side : side + "_" + part;
}

std::optional<MarkerNames> ParseMarkerNames(const std::string& text) {
  if (text == "ours") return MarkerNames::kOurs;
  if (text == "pose2sim") return MarkerNames::kPose2Sim;
  if (text == "opensim") return MarkerNames::kOpenSim;
  return std::nullopt;
}

Skeleton WithMarkerNames(const Skeleton& skeleton, MarkerNames names) {
  if (names == MarkerNames::kOurs) return skeleton;
  std::vector<std::string> markers;
  for (const std::string& joint : skeleton.joints()) {
    if (joint == "head_top") {
      markers.emplace_back("Head");
    } else if (joint == "mid_hip") {
      markers.emplace_back(names == MarkerNames::kOpenSim ? "midHip"
                           : skeleton == Body25()         ? "CHip"
                                                          : "Hip");
    } else {
      markers.push_back(CamelCase(joint));
    }
  }
  return Skeleton(skeleton.name(), markers, skeleton.bones());
}

Skeleton WithOurNames(const Skeleton& skeleton) {
  std::vector<std::string> joints;
  for (const std::string& label : skeleton.joints()) {
    joints.push_back(JointNameOf(label));
    if (std::count(joints.begin(), joints.end(), joints.back()) > 1) {
      return skeleton;
    }
  }
  return Skeleton(skeleton.name(), joints, skeleton.bones());
}

Skeleton SkeletonOfLabels(const std::vector<std::string>& labels) {
  std::vector<std::string> joints;
  joints.reserve(labels.size());
  for (const std::string& label : labels) joints.push_back(JointNameOf(label));
  if (const Skeleton* known = FindSkeletonOf(joints)) return *known;
  try {
    const Skeleton bare("custom", joints, {});
    std::vector<Bone> bones;
    for (const Bone& bone : Coco17().bones()) {
      const Bone own = {
          bare.IndexOf(Coco17().joints()[static_cast<size_t>(bone.a)]),
          bare.IndexOf(Coco17().joints()[static_cast<size_t>(bone.b)])};
      if (own.a >= 0 && own.b >= 0) bones.push_back(own);
    }
    return Skeleton("custom", joints, bones);
  } catch (const OptionError& error) {
    throw InputError(std::string("joints: ") + error.message());
  }
}

}  // namespace kinegraph
