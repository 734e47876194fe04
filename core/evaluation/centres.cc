#include "core/evaluation/centres.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

// The joints whose mean is the middle of the hips; empty: there is none.
std::vector<int> MiddleOfHips(const Skeleton& skeleton) {
  const int mid_hip = skeleton.IndexOf("mid_hip");
  if (mid_hip >= 0) return {mid_hip};
  const int left = skeleton.IndexOf("l_hip");
  const int right = skeleton.IndexOf("r_hip");
  if (left < 0 || right < 0) return {};
  return {left, right};
}

Joint3d MeanJoint(const Pose3d& joints) {
  const std::optional<Eigen::Vector3d> mean = MeanPosition(joints);
  if (!mean.has_value()) return {};
  const bool is_observed =
      std::any_of(joints.begin(), joints.end(), [](const Joint3d& joint) {
        return joint.status == JointStatus::kObserved;
      });
  return {*mean, is_observed ? JointStatus::kObserved : JointStatus::kInferred};
}

Joint3d CentreOf(const Pose3d& pose, const std::vector<int>& hips) {
  Pose3d middle;
  for (const int j : hips) {
    if (pose[j].present()) middle.push_back(pose[j]);
  }
  return MeanJoint(middle.empty() || middle.size() < hips.size() ? pose
                                                                 : middle);
}

TrackSequence CentresOf(const TrackSequence& tracks) {
  const std::vector<int> hips = MiddleOfHips(tracks.header.skeleton);
  TrackSequence centres;
  centres.header = tracks.header;
  centres.header.skeleton = Skeleton("centre", {"centre"}, {});
  for (const TrackFrame& frame : tracks.frames) {
    TrackFrame& reduced = centres.frames.emplace_back();
    reduced.frame = frame.frame;
    reduced.time = frame.time;
    for (const PersonPose& person : frame.people) {
      PersonPose& centre = reduced.people.emplace_back();
      centre.id = person.id;
      centre.joints = {CentreOf(person.joints, hips)};
    }
  }
  return centres;
}

}  // namespace

std::optional<Centres> ReducedToCentres(const TrackSequence& a,
                                        const TrackSequence& b) {
  const Skeleton* centroid = &a.header.skeleton;
  const Skeleton* whole = &b.header.skeleton;
  if (centroid->joint_count() != 1) std::swap(centroid, whole);
  if (centroid->joint_count() != 1 ||
      !CommonJoints(*centroid, *whole).empty()) {
    return std::nullopt;
  }
  return Centres{CentresOf(a), CentresOf(b),
                 "people are compared by their centres: '" +
                     Printable(centroid->joints()[0]) + "' and the " +
                     (MiddleOfHips(*whole).empty() ? "mean of all joints"
                                                   : "middle of the hips")};
}

}  // namespace kinegraph
