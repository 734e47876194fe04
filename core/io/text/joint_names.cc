#include "core/io/text/joint_names.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

// The letters and digits of a label, in lower case.
std::string Squeezed(std::string_view label) {
  std::string squeezed;
  for (const char c : label) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) {
      squeezed += static_cast<char>(std::tolower(byte));
    }
  }
  return squeezed;
}

// A part of the body as named in labels.
struct Part {
  std::string squeezed;
  // kinegraph's name if another label of the file matches `joint` more exactly:
  // "foot" beside "ankle".
  std::string own;
  std::string joint;  // kinegraph's name otherwise
};

// Parses a list of "own" (which is the joint) or "own=joint".
std::vector<Part> PartsOf(const std::string& list) {
  std::vector<Part> parts;
  for (const std::string& part : Split(list, ' ')) {
    const std::vector<std::string> names = Split(part, '=');
    parts.push_back({Squeezed(names[0]), names[0], names.back()});
  }
  return parts;
}

// The parts that may be the same joint are in order, the more exact ones first.
const std::vector<Part>& SidedParts() {
  static const std::vector<Part> kParts = PartsOf(
      "eye eye_inner eye_outer ear mouth shoulder elbow wrist hand=wrist pinky "
      "index thumb hip knee ankle foot=ankle heel big_toe toe=big_toe "
      "toes=big_toe small_toe foot_index");
  return kParts;
}
const std::vector<Part>& CentralParts() {
  static const std::vector<Part> kParts = PartsOf(
      "nose neck head_top top_head=head_top head=head_top forehead=head_top "
      "head_bottom chin=head_bottom mid_hip chip=mid_hip pelvis=mid_hip "
      "hips=mid_hip hip=mid_hip root=mid_hip");
  return kParts;
}

// The interpretation of a label.
struct Meaning {
  enum class Kind { kExact, kVague, kNone };
  Kind kind = Kind::kNone;
  std::string joint;  // kinegraph's name; the label itself if unknown
  std::string own;    // the name if another label gets `joint` (Part)
  int vagueness = 0;  // higher: less exact
};

// The meaning of a label whose squeezed name is one of `parts`.
std::optional<Meaning> MeaningAmong(const std::vector<Part>& parts,
                                    const std::string& squeezed,
                                    const std::string& side,
                                    const std::string& label) {
  const auto part =
      std::find_if(parts.begin(), parts.end(),
                   [&](const Part& one) { return one.squeezed == squeezed; });
  if (part == parts.end()) return std::nullopt;
  const std::string joint = side + part->joint;
  const std::string own = side + part->own;
  // kinegraph's own spelling has precedence.
  return Meaning{joint == own ? Meaning::Kind::kExact : Meaning::Kind::kVague,
                 joint, own,
                 label == joint ? -1 : static_cast<int>(part - parts.begin())};
}

// "LAnkle(mm)" and "LAnkle (mm)" -> "LAnkle".
std::string WithoutUnit(const std::string& label) {
  if (label.empty() || (label.back() != ')' && label.back() != ']')) {
    return label;
  }
  const size_t begin = label.find_last_of("([");
  if (begin == std::string::npos) return label;
  const std::string unit = label.substr(begin + 1, label.size() - begin - 2);
  for (const char* known : {"m", "cm", "mm", "px"}) {
    if (unit == known) return Trimmed(label.substr(0, begin));
  }
  return label;
}

bool Strip(const std::string& text, const std::string& end, bool at_front,
           std::string* rest) {
  if (text.size() <= end.size()) return false;
  const size_t at = at_front ? 0 : text.size() - end.size();
  if (text.compare(at, end.size(), end) != 0) return false;
  *rest = at_front ? text.substr(end.size()) : text.substr(0, at);
  return true;
}

// "Anna:LAnkle(mm)" -> "LAnkle".
std::string PartIn(const std::string& label) {
  const std::string name = WithoutUnit(label);
  return name.substr(name.find_last_of(':') + 1);  // npos + 1 is 0
}

// Whether the label is "rear": the back of a box or vehicle or, beside a left
// ear, the right ear.
bool IsRear(const std::string& label) {
  const std::string part = PartIn(label);
  return part == "rear" || part == "Rear" || part == "REAR";
}

Meaning MeaningOf(const std::string& label) {
  if (IsRear(label)) return {Meaning::Kind::kNone, label, label, -1};
  const std::string squeezed = Squeezed(PartIn(label));
  if (auto meaning = MeaningAmong(CentralParts(), squeezed, "", label)) {
    return *meaning;
  }
  std::string rest;
  for (const auto& [word, side] :
       {std::pair{"left", "l_"}, {"right", "r_"}, {"l", "l_"}, {"r", "r_"}}) {
    for (const bool at_front : {true, false}) {
      if (!Strip(squeezed, word, at_front, &rest)) continue;
      if (auto meaning = MeaningAmong(SidedParts(), rest, side, label)) {
        return *meaning;
      }
    }
  }
  // Others, such as the numbered points of a face: "left_face_3".
  for (const auto& [word, side] :
       {std::pair{"left_", "l_"}, {"right_", "r_"}}) {
    if (Strip(label, word, /*at_front=*/true, &rest)) {
      return {Meaning::Kind::kNone, side + rest, label};
    }
  }
  return {Meaning::Kind::kNone, label, label, -1};
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
  return MeaningOf(label).joint;
}

std::vector<std::string> OurJointNames(const std::vector<std::string>& labels) {
  std::vector<Meaning> meanings;
  for (const std::string& label : labels) meanings.push_back(MeaningOf(label));
  const bool has_l_ear = std::any_of(
      meanings.begin(), meanings.end(),
      [](const Meaning& meaning) { return meaning.joint == "l_ear"; });
  for (size_t i = 0; i < labels.size(); ++i) {
    if (has_l_ear && IsRear(labels[i])) meanings[i] = MeaningOf("r ear");
  }
  const bool are_human =
      std::none_of(labels.begin(), labels.end(), IsAnimalPart) &&
      std::any_of(meanings.begin(), meanings.end(), [](const Meaning& meaning) {
        return meaning.kind == Meaning::Kind::kExact;
      });
  std::map<std::string, size_t> exactest;  // by the joint
  for (size_t i = 0; i < labels.size(); ++i) {
    if (!are_human && meanings[i].kind == Meaning::Kind::kVague) {
      meanings[i] = {Meaning::Kind::kNone, labels[i], labels[i], -1};
    }
    size_t& best = exactest.try_emplace(meanings[i].joint, i).first->second;
    if (meanings[i].vagueness < meanings[best].vagueness) best = i;
  }
  std::vector<std::string> names(labels.size());
  std::set<std::string> taken;
  const auto give = [&](size_t i, const std::string& name) {
    if (names[i].empty() && taken.insert(name).second) names[i] = name;
  };
  for (const auto& [joint, i] : exactest) give(i, joint);
  // Labels in kinegraph's own spelling are kept before others get their names.
  for (size_t i = 0; i < labels.size(); ++i) {
    if (meanings[i].own == labels[i]) give(i, labels[i]);
  }
  for (size_t i = 0; i < labels.size(); ++i) {
    give(i, meanings[i].own);
    if (names[i].empty()) names[i] = labels[i];
  }
  return names;
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
    if (joint == "head_top" && skeleton.IndexOf("head") < 0) {
      markers.emplace_back("Head");
    } else if (joint == "mid_hip" && skeleton.IndexOf("hip") < 0) {
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
  return Skeleton(skeleton.name(), OurJointNames(skeleton.joints()),
                  skeleton.bones());
}

namespace {

// The built-in skeleton with these joints, or nullptr. Recognises
// COCO-WholeBody even though MMPose names the points of face and hands
// differently.
const Skeleton* FindKnown(const std::vector<std::string>& joints) {
  constexpr int kNamedAlike = 23;  // body and feet
  const std::vector<std::string>& whole = WholeBody133().joints();
  if (joints.size() == whole.size() &&
      std::equal(joints.begin(), joints.begin() + kNamedAlike, whole.begin())) {
    return &WholeBody133();
  }
  return FindSkeletonOf(joints);
}

// The bones of COCO-17 between the existing joints.
std::vector<Bone> HumanBones(const Skeleton& skeleton) {
  std::vector<Bone> bones;
  if (!IsHuman(skeleton)) return bones;
  const std::vector<int> own = MapByName(skeleton, Coco17());
  for (const Bone& bone : Coco17().bones()) {
    const Bone here = {own[static_cast<size_t>(bone.a)],
                       own[static_cast<size_t>(bone.b)]};
    if (here.a >= 0 && here.b >= 0) bones.push_back(here);
  }
  return bones;
}

}  // namespace

Skeleton SkeletonOfLabels(const std::vector<std::string>& labels,
                          const std::vector<Bone>& bones,
                          const std::string& name) {
  std::set<std::string> once;
  for (const std::string& label : labels) {
    if (once.insert(label).second) continue;
    throw InputError("joints: '" + Printable(label) + "' appears twice");
  }
  const std::vector<std::string> joints = OurJointNames(labels);
  try {
    if (const Skeleton* known = FindKnown(joints)) {
      return bones.empty() ? *known
                           : Skeleton(known->name(), known->joints(), bones);
    }
    const bool is_free = !name.empty() && FindSkeleton(name) == nullptr;
    const Skeleton bare(is_free ? name : "custom", joints, bones);
    if (!bones.empty()) return bare;
    return Skeleton(bare.name(), joints, HumanBones(bare));
  } catch (const OptionError& error) {
    throw InputError(error.key() + ": " + error.message());
  }
}

}  // namespace kinegraph
