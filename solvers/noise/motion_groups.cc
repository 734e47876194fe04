#include "solvers/noise/motion_groups.h"

#include <algorithm>
#include <map>
#include <utility>

namespace kinegraph {
namespace {

bool MovesWithTheBody(JointClass joint_class) {
  return joint_class == JointClass::kHead ||
         joint_class == JointClass::kTrunk ||
         joint_class == JointClass::kShoulder ||
         joint_class == JointClass::kHip;
}

enum class Side { kNone, kLeft, kRight };

Side SideOf(const Skeleton& skeleton, int joint_idx) {
  if (skeleton.mirror(joint_idx) == joint_idx) return Side::kNone;
  const bool left = skeleton.joints()[joint_idx].rfind("l_", 0) == 0;
  return left ? Side::kLeft : Side::kRight;
}

}  // namespace

MotionGroups::MotionGroups(const Skeleton& skeleton) {
  std::map<std::pair<JointClass, Side>, int> known;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const JointClass joint_class = skeleton.joint_class(j);
    const Side side =
        MovesWithTheBody(joint_class) ? Side::kNone : SideOf(skeleton, j);
    const auto [group, is_new] =
        known.try_emplace({joint_class, side}, static_cast<int>(known.size()));
    if (is_new) classes_.push_back(joint_class);
    of_joint_.push_back(group->second);
  }
}

double MotionGroups::share_of_class(int group) const {
  return 1.0 / static_cast<double>(std::count(classes_.begin(), classes_.end(),
                                              classes_[group]));
}

}  // namespace kinegraph
