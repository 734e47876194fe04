#include "core/skeleton/skeleton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

using Names = std::vector<std::string>;

// A built-in skeleton: its joints in their published order, and its bones as
// pairs of joints.
struct Layout {
  const char* name;
  const char* joints;
  const char* bones;
};

// The words of a text; the name of a group expands to the words of the group.
Names Words(const std::string& text) {
  static const std::map<std::string, std::string> kGroups = {
      {"coco17",
       "nose l_eye r_eye l_ear r_ear l_shoulder r_shoulder l_elbow r_elbow "
       "l_wrist r_wrist l_hip r_hip l_knee r_knee l_ankle r_ankle"},
      {"limbs",
       "l_shoulder-l_elbow l_elbow-l_wrist l_hip-l_knee l_knee-l_ankle "
       "r_shoulder-r_elbow r_elbow-r_wrist r_hip-r_knee r_knee-r_ankle"},
      {"girdles",
       "l_shoulder-r_shoulder l_hip-r_hip l_shoulder-l_hip r_shoulder-r_hip"},
      {"face", "nose-l_eye nose-r_eye l_eye-l_ear r_eye-r_ear"},
      // The trunk of skeletons that have a neck and a mid-hip.
      {"spine",
       "neck-l_shoulder neck-r_shoulder neck-mid_hip mid_hip-l_hip "
       "mid_hip-r_hip neck-nose"},
      {"feet",
       "l_ankle-l_big_toe l_ankle-l_small_toe l_ankle-l_heel "
       "r_ankle-r_big_toe r_ankle-r_small_toe r_ankle-r_heel"}};
  Names words;
  for (const std::string& word : Split(text, ' ')) {
    const auto group = kGroups.find(word);
    if (group == kGroups.end()) {
      words.push_back(word);
    } else {
      const Names more = Split(group->second, ' ');
      words.insert(words.end(), more.begin(), more.end());
    }
  }
  return words;
}

Skeleton Make(const std::string& name, const Names& joints,
              const std::string& bones) {
  std::vector<Bone> found;
  for (const std::string& bone : Words(bones)) {
    Bone& ends = found.emplace_back();
    for (int* end : {&ends.a, &ends.b}) {
      const std::string joint = Split(bone, '-')[end == &ends.a ? 0 : 1];
      *end = static_cast<int>(std::find(joints.begin(), joints.end(), joint) -
                              joints.begin());
    }
  }
  return Skeleton(name, joints, std::move(found));
}

bool StartsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

const Names& Coco17Joints() {
  static const Names kJoints = Words("coco17");
  return kJoints;
}

}  // namespace

const char* ToString(JointClass joint_class) {
  static constexpr std::array<const char*, kJointClassCount> kNames = {
      "head", "trunk", "shoulder", "elbow", "wrist",
      "hip",  "knee",  "ankle",    "foot",  "other"};
  return kNames[static_cast<size_t>(joint_class)];
}

JointClass ClassOfJoint(const std::string& joint_name) {
  const bool sided =
      StartsWith(joint_name, "l_") || StartsWith(joint_name, "r_");
  const std::string part = sided ? joint_name.substr(2) : joint_name;
  if (part == "nose" || part == "ear" || StartsWith(part, "eye") ||
      part == "mouth" || part == "head_top" || part == "head_bottom" ||
      part == "head" || part == "forehead" || StartsWith(part, "face_")) {
    return JointClass::kHead;
  }
  if (part == "neck" || part == "mid_hip") return JointClass::kTrunk;
  if (part == "shoulder") return JointClass::kShoulder;
  if (part == "elbow") return JointClass::kElbow;
  if (part == "wrist") return JointClass::kWrist;
  if (part == "hip") return JointClass::kHip;
  if (part == "knee") return JointClass::kKnee;
  if (part == "ankle") return JointClass::kAnkle;
  if (part == "heel" || part == "big_toe" || part == "small_toe" ||
      part == "foot_index" || part == "foot" || part == "toe") {
    return JointClass::kFoot;
  }
  return JointClass::kOther;
}

Skeleton::Skeleton(std::string name, std::vector<std::string> joints,
                   std::vector<Bone> bones)
    : name_(std::move(name)),
      joints_(std::move(joints)),
      bones_(std::move(bones)) {
  const int count = joint_count();
  if (count == 0)
    throw OptionError("joints", "a skeleton needs at least one joint");
  // Bounded because names are compared pairwise.
  constexpr int kMaxJoints = 10000;
  if (count > kMaxJoints) {
    throw OptionError("joints", "a skeleton of " + std::to_string(count) +
                                    " joints, expected at most " +
                                    std::to_string(kMaxJoints));
  }
  for (int j = 0; j < count; ++j) {
    if (joints_[j].empty()) {
      throw OptionError("joints",
                        "joint " + std::to_string(j) + " has no name");
    }
    if (IndexOf(joints_[j]) != j) {
      throw OptionError("joints", "'" + joints_[j] + "' appears twice");
    }
  }
  for (const Bone& bone : bones_) {
    const bool inside = bone.a >= 0 && bone.a < count && bone.b >= 0 &&
                        bone.b < count && bone.a != bone.b;
    if (!inside) {
      throw OptionError("bones", "[" + std::to_string(bone.a) + ", " +
                                     std::to_string(bone.b) +
                                     "] does not join two of the " +
                                     std::to_string(count) + " joints");
    }
  }
  mirror_.resize(joints_.size());
  classes_.resize(joints_.size());
  for (int j = 0; j < count; ++j) {
    int partner = -1;
    if (StartsWith(joints_[j], "l_")) {
      partner = IndexOf("r_" + joints_[j].substr(2));
    } else if (StartsWith(joints_[j], "r_")) {
      partner = IndexOf("l_" + joints_[j].substr(2));
    }
    mirror_[j] = partner < 0 ? j : partner;
    classes_[j] = ClassOfJoint(joints_[j]);
  }
  for (const std::string& joint : Coco17Joints()) {
    const int index = IndexOf(joint);
    if (index >= 0) association_joints_.push_back(index);
  }
  if (association_joints_.size() < (Coco17Joints().size() + 1) / 2 ||
      !IsHuman(*this)) {
    association_joints_.resize(joints_.size());
    for (int j = 0; j < count; ++j) association_joints_[j] = j;
  }
}

int Skeleton::IndexOf(const std::string& joint_name) const {
  const auto at = std::find(joints_.begin(), joints_.end(), joint_name);
  return at == joints_.end() ? -1 : static_cast<int>(at - joints_.begin());
}

bool operator==(const Skeleton& a, const Skeleton& b) {
  return a.name() == b.name() && a.joints() == b.joints();
}

namespace {

// Name of iBUG's face point `point` of 68. Points of a pair share the number of
// the one on the person's right.
std::string FacePoint(int point) {
  // Rows of points that mirror each other: first <-> last, and so on.
  constexpr std::array<std::array<int, 2>, 6> kRows = {
      {{0, 16}, {17, 26}, {31, 35}, {48, 54}, {55, 59}, {60, 64}}};
  int partner = point;
  for (const auto& [first, last] : kRows) {
    if (point >= first && point <= last) partner = first + last - point;
  }
  if (point >= 36 && point <= 39) partner = 81 - point;  // upper lids 36..39
  if (point >= 42 && point <= 45) partner = 81 - point;
  if (point == 40 || point == 41) partner = 87 - point;  // lower lids
  if (point == 46 || point == 47) partner = 87 - point;
  if (point >= 65) partner = 132 - point;  // inner lower lip 65..67
  if (partner == point) return "face_" + std::to_string(point);
  // In iBUG's order the person's right comes first, except along the lower lip,
  // which runs back from left to right.
  const bool lower_lip = (point >= 55 && point <= 59) || point >= 65;
  const bool right = lower_lip ? point > partner : point < partner;
  return (right ? "r_face_" : "l_face_") +
         std::to_string(right ? point : partner);
}

// COCO-WholeBody: the joints after COCO-17's and the bones of the fingers are
// numbered, so they are generated.
Skeleton MakeWholeBody133() {
  Names joints = Coco17Joints();
  for (const std::string side : {"l_", "r_"}) {
    for (const char* part : {"big_toe", "small_toe", "heel"}) {
      joints.push_back(side + part);
    }
  }
  for (int point = 0; point < 68; ++point) joints.push_back(FacePoint(point));
  std::string bones = "limbs girdles face feet";
  for (const std::string side : {"l_", "r_"}) {
    const std::string hand = side + "hand_";
    bones += " " + side + "wrist-" + hand + "0";
    for (int point = 0; point < 21; ++point) {
      joints.push_back(hand + std::to_string(point));
      if (point == 0) continue;
      const int before = point % 4 == 1 ? 0 : point - 1;
      bones += " " + hand + std::to_string(before) + "-" + joints.back();
    }
  }
  return Make("wholebody133", joints, bones);
}

// Among skeletons with equally many joints the most common comes first.
constexpr Layout kLayouts[] = {
    {"coco17", "coco17",
     "limbs girdles face l_ear-l_shoulder r_ear-r_shoulder"},
    {"body25",
     "nose neck r_shoulder r_elbow r_wrist l_shoulder l_elbow l_wrist mid_hip "
     "r_hip r_knee r_ankle l_hip l_knee l_ankle r_eye l_eye r_ear l_ear "
     "l_big_toe l_small_toe l_heel r_big_toe r_small_toe r_heel",
     "limbs spine face feet"},
    {"body25b",
     "coco17 neck head_top l_big_toe l_small_toe l_heel r_big_toe r_small_toe "
     "r_heel",
     "limbs girdles face feet neck-head_top neck-nose"},
    {"halpe26",
     "coco17 head_top neck mid_hip l_big_toe r_big_toe l_small_toe r_small_toe "
     "l_heel r_heel",
     "limbs spine face feet neck-head_top"},
    {"mediapipe33",
     "nose l_eye_inner l_eye l_eye_outer r_eye_inner r_eye r_eye_outer l_ear "
     "r_ear l_mouth r_mouth l_shoulder r_shoulder l_elbow r_elbow l_wrist "
     "r_wrist l_pinky r_pinky l_index r_index l_thumb r_thumb l_hip r_hip "
     "l_knee r_knee l_ankle r_ankle l_heel r_heel l_foot_index r_foot_index",
     "limbs girdles l_eye_inner-l_eye l_eye-l_eye_outer l_eye_outer-l_ear "
     "l_wrist-l_pinky l_wrist-l_index l_wrist-l_thumb l_pinky-l_index "
     "l_ankle-l_heel l_heel-l_foot_index l_ankle-l_foot_index nose-l_eye_inner "
     "r_eye_inner-r_eye r_eye-r_eye_outer r_eye_outer-r_ear r_wrist-r_pinky "
     "r_wrist-r_index r_wrist-r_thumb r_pinky-r_index r_ankle-r_heel "
     "r_heel-r_foot_index r_ankle-r_foot_index nose-r_eye_inner "
     "l_mouth-r_mouth"},
    {"coco18",
     "nose neck r_shoulder r_elbow r_wrist l_shoulder l_elbow l_wrist r_hip "
     "r_knee r_ankle l_hip l_knee l_ankle r_eye l_eye r_ear l_ear",
     "limbs face neck-l_shoulder neck-r_shoulder neck-l_hip neck-r_hip "
     "neck-nose"},
    {"tum14",
     "r_ankle r_knee r_hip l_hip l_knee l_ankle r_wrist r_elbow r_shoulder "
     "l_shoulder l_elbow l_wrist head_bottom head_top",
     "limbs girdles head_bottom-head_top head_bottom-l_shoulder "
     "head_bottom-r_shoulder"},
    {"tum15",
     "r_ankle r_knee r_hip l_hip l_knee l_ankle r_wrist r_elbow r_shoulder "
     "l_shoulder l_elbow l_wrist head_bottom head_top mid_hip",
     "limbs girdles head_bottom-head_top head_bottom-l_shoulder "
     "head_bottom-r_shoulder mid_hip-l_hip mid_hip-r_hip"},
    {"panoptic15",
     "neck nose mid_hip l_shoulder l_elbow l_wrist l_hip l_knee l_ankle "
     "r_shoulder r_elbow r_wrist r_hip r_knee r_ankle",
     "limbs spine"},
    {"panoptic19",
     "neck nose mid_hip l_shoulder l_elbow l_wrist l_hip l_knee l_ankle "
     "r_shoulder r_elbow r_wrist r_hip r_knee r_ankle l_eye l_ear r_eye r_ear",
     "limbs spine face"},
    {"4da19",
     "mid_hip neck r_hip l_hip nose r_shoulder l_shoulder r_knee l_knee r_ear "
     "l_ear r_elbow l_elbow r_ankle l_ankle r_wrist l_wrist l_big_toe "
     "r_big_toe",
     "limbs spine nose-l_ear nose-r_ear l_ankle-l_big_toe r_ankle-r_big_toe"},
};

const std::vector<Skeleton>& BuiltIn() {
  static const std::vector<Skeleton> kAll = [] {
    std::vector<Skeleton> all;
    for (const Layout& layout : kLayouts) {
      all.push_back(Make(layout.name, Words(layout.joints), layout.bones));
    }
    all.push_back(MakeWholeBody133());
    return all;
  }();
  return kAll;
}

}  // namespace

const Skeleton& Coco17() { return BuiltIn()[0]; }
const Skeleton& Body25() { return BuiltIn()[1]; }
const Skeleton& Body25B() { return BuiltIn()[2]; }
const Skeleton& Halpe26() { return BuiltIn()[3]; }
const Skeleton& MediaPipe33() { return BuiltIn()[4]; }
const Skeleton& Coco18() { return BuiltIn()[5]; }
const Skeleton& Tum14() { return BuiltIn()[6]; }
const Skeleton& Tum15() { return BuiltIn()[7]; }
const Skeleton& Panoptic15() { return BuiltIn()[8]; }
const Skeleton& Panoptic19() { return BuiltIn()[9]; }
const Skeleton& FourDA19() { return BuiltIn()[10]; }
const Skeleton& WholeBody133() { return BuiltIn()[11]; }

const Skeleton* FindSkeleton(const std::string& name) {
  for (const Skeleton& skeleton : BuiltIn()) {
    if (skeleton.name() == name) return &skeleton;
  }
  return nullptr;
}

std::vector<std::string> SkeletonNames() {
  std::vector<std::string> names;
  for (const Skeleton& skeleton : BuiltIn()) names.push_back(skeleton.name());
  return names;
}

const Skeleton* FindSkeletonOf(const std::vector<std::string>& joints) {
  for (const Skeleton& skeleton : BuiltIn()) {
    if (skeleton.joints() == joints) return &skeleton;
  }
  return nullptr;
}

std::vector<const Skeleton*> SkeletonsOfSize(size_t joint_count) {
  std::vector<const Skeleton*> found;
  for (const Skeleton& skeleton : BuiltIn()) {
    if (skeleton.joints().size() == joint_count) found.push_back(&skeleton);
  }
  return found;
}

int ScaledJoints(double joints_of_17, size_t count) {
  // 11 / 17 * 17 must remain 11 in spite of rounding.
  constexpr double kSlack = 1e-9;
  const double joints = joints_of_17 /
                        static_cast<double>(Coco17Joints().size()) *
                        static_cast<double>(count);
  return static_cast<int>(std::ceil(joints - kSlack));
}

std::vector<int> MapByName(const Skeleton& from, const Skeleton& to) {
  std::vector<int> map;
  map.reserve(to.joints().size());
  for (const std::string& joint : to.joints())
    map.push_back(from.IndexOf(joint));
  return map;
}

}  // namespace kinegraph
