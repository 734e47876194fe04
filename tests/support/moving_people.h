// People whose limbs move independently, and their exact projections.
#ifndef KINEGRAPH_TESTS_SUPPORT_MOVING_PEOPLE_H_
#define KINEGRAPH_TESTS_SUPPORT_MOVING_PEOPLE_H_

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/base/constants.h"
#include "solvers/rig/tracklets.h"
#include "solvers/rig/two_views.h"
#include "tests/support/rig.h"

namespace kinegraph::testing {

inline constexpr double kMovingRateHz = 25.0;

// Person `who` in COCO-17 at a (fractional) frame, centred within 1.4 m of the
// z axis. Motions differ between people and do not repeat within a minute.
inline Pose3d MovingPerson(int who, double frame) {
  const double t = frame / kMovingRateHz;
  Pose3d pose = StandingPerson(0.0, 0.0);
  for (size_t j = 7; j < pose.size(); ++j) {
    if (j == 11 || j == 12) continue;  // hips
    const double own = static_cast<double>(j) + 2.3 * who;
    pose[j].position_m.y() +=
        0.15 * std::sin(2.0 * kPi * (0.5 + 0.07 * own) * t + own);
    pose[j].position_m.z() +=
        0.06 * std::sin(2.0 * kPi * (0.8 + 0.05 * own) * t + 2.0 * own);
  }
  const Eigen::AngleAxisd heading(1.5 * who + 0.8 * std::sin(0.9 * t + who),
                                  Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d place(
      0.6 * std::cos(2.2 * who) + 0.6 * std::sin(0.7 * t + 1.3 * who),
      0.6 * std::sin(2.2 * who) + 0.5 * std::sin(1.1 * t + 2.1 * who + 0.5),
      0.0);
  for (Joint3d& joint : pose) {
    joint.position_m = heading * joint.position_m + place;
  }
  return pose;
}

// The tracklet of person `who` in a view, with `frames` frames, without noise.
// Its frame k shows frame k - `late` of the motion.
inline ViewTracklet MovingTracklet(const Camera& camera, int view, int who,
                                   int frames, int late = 0) {
  const std::vector<int> joints = RigJoints(Coco17());
  ViewTracklet tracklet;
  tracklet.view = view;
  for (int k = 0; k < frames; ++k) {
    const Pose3d pose = MovingPerson(who, k - late);
    NormalisedJoints points(2, static_cast<Eigen::Index>(joints.size()));
    for (size_t j = 0; j < joints.size(); ++j) {
      points.col(static_cast<Eigen::Index>(j)) =
          (camera.R() * pose[joints[j]].position_m + camera.t()).hnormalized();
    }
    tracklet.detections.push_back(who);
    tracklet.joints.push_back(points);
  }
  const NormalisedJoints& points = tracklet.joints.front();
  tracklet.size =
      (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
  return tracklet;
}

// The pose of camera b relative to camera a; its translation has length 1.
inline RelativePose PoseBetween(const Camera& a, const Camera& b) {
  RelativePose pose;
  pose.R = b.R() * a.R().transpose();
  pose.t = (b.t() - pose.R * a.t()).normalized();
  return pose;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_MOVING_PEOPLE_H_
