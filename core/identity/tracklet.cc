#include "core/identity/tracklet.h"

#include <map>
#include <optional>
#include <utility>

#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

std::optional<Eigen::Vector3d> Centre(const Pose3d& pose,
                                      const std::vector<int>& trunk) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const int j : trunk) {
    if (!pose[j].present() || !pose[j].position_m.allFinite()) continue;
    sum += pose[j].position_m;
    ++count;
  }
  if (count == 0) return MeanPosition(pose);
  return Eigen::Vector3d(sum / count);
}

Eigen::Vector3d Across(const Pose3d& pose, const Skeleton& skeleton,
                       const std::vector<int>& trunk) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const int left : trunk) {
    const int right = skeleton.mirror(left);
    if (skeleton.joints()[static_cast<size_t>(left)][0] != 'l' ||
        right == left || !pose[left].present() || !pose[right].present()) {
      continue;
    }
    sum += pose[left].position_m - pose[right].position_m;
    ++count;
  }
  return count == 0 || !sum.allFinite() ? Eigen::Vector3d::Zero().eval()
                                        : Eigen::Vector3d(sum / count);
}

}  // namespace

std::vector<Tracklet> CollectTracklets(const std::vector<TrackFrame>& frames,
                                       const Skeleton& skeleton) {
  std::vector<int> trunk;
  std::vector<int> body_joints;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const JointClass joint_class = skeleton.joint_class(j);
    if (IsBodyJoint(joint_class)) body_joints.push_back(j);
    if (joint_class == JointClass::kHip ||
        joint_class == JointClass::kShoulder) {
      trunk.push_back(j);
    }
  }
  std::map<TrackId, Tracklet> people;
  for (const TrackFrame& frame : frames) {
    for (const PersonPose& person : frame.people) {
      const std::optional<Eigen::Vector3d> centre =
          Centre(person.joints, trunk);
      if (!centre.has_value()) continue;
      people[person.id].frames.push_back(
          {frame.frame, frame.time, &person, *centre,
           Across(person.joints, skeleton, trunk)});
    }
  }
  std::vector<Tracklet> tracklets;
  for (auto& [id, tracklet] : people) {
    tracklet.id = id;
    tracklet.body_joints = body_joints;
    tracklets.push_back(std::move(tracklet));
  }
  return tracklets;
}

}  // namespace kinegraph
