#include "core/skeleton/body_joints.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

namespace kinegraph {

bool IsAnimalPart(const std::string& label) {
  constexpr std::array<const char*, 9> kAnywhere = {
      "paw",     "hoof",    "snout",   "muzzle", "beak",
      "whisker", "antenna", "withers", "hock"};
  constexpr std::array<const char*, 2> kAtAWordsBegin = {"tail", "wing"};
  std::string text = " ";
  bool was_small = false;
  for (const char c : label) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_letter = std::isalpha(byte) != 0;
    if (!is_letter || (was_small && std::isupper(byte) != 0)) text += ' ';
    if (is_letter) text += static_cast<char>(std::tolower(byte));
    was_small = std::islower(byte) != 0;
  }
  const auto has = [&text](const std::string& word) {
    return text.find(word) != std::string::npos;
  };
  return std::any_of(kAnywhere.begin(), kAnywhere.end(), has) ||
         std::any_of(
             kAtAWordsBegin.begin(), kAtAWordsBegin.end(),
             [&has](const std::string& word) { return has(" " + word); });
}

bool IsBodyJoint(JointClass joint_class) {
  switch (joint_class) {
    case JointClass::kShoulder:
    case JointClass::kElbow:
    case JointClass::kWrist:
    case JointClass::kHip:
    case JointClass::kKnee:
    case JointClass::kAnkle:
      return true;
    default:
      return false;
  }
}

bool IsHuman(const Skeleton& skeleton) {
  const auto has = [&skeleton](const std::string& joint) {
    return skeleton.IndexOf(joint) >= 0;
  };
  bool has_limb = false;
  for (const std::string side : {"l_", "r_"}) {
    has_limb |=
        has(side + "shoulder") && has(side + "elbow") && has(side + "wrist");
    has_limb |= has(side + "hip") && has(side + "knee") && has(side + "ankle");
  }
  const std::vector<std::string>& joints = skeleton.joints();
  return has_limb && std::none_of(joints.begin(), joints.end(), IsAnimalPart);
}

}  // namespace kinegraph
