#include "core/synthetic/sight.h"

#include <cmath>

#include "core/base/constants.h"
#include "core/synthetic/actor.h"

namespace kinegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Direction of the camera as the person sees it [deg].
double AzimuthOf(const Camera& camera, const SegmentPose& trunk) {
  const Vector3d to_camera = camera.centre() - trunk.origin_m;
  const double forward = to_camera.dot(trunk.R.col(0));
  const double right = -to_camera.dot(trunk.R.col(1));
  return std::atan2(right, forward) * 180.0 / kPi;
}

}  // namespace

SceneMoment LookAtScene(const Scene& scene, TimeNs time, bool with_obstacles) {
  SceneMoment moment;
  moment.time = time;
  const double time_s = ToSeconds(time);
  for (const auto& person : scene.people) {
    moment.poses.push_back(PersonAt(*person, time));
    const bool present = !moment.poses.back().empty();
    moment.trunks.push_back(present ? person->TrunkAt(time_s) : SegmentPose());
    if (!with_obstacles) continue;
    moment.obstacles.emplace_back();
    if (present) moment.obstacles.back() = person->ObstacleAt(time_s);
  }
  return moment;
}

std::vector<PersonSight> Sights(const Camera& camera, const SceneMoment& moment,
                                int joint_count) {
  std::vector<PersonSight> sights(moment.poses.size());
  for (size_t i = 0; i < sights.size(); ++i) {
    PersonSight& sight = sights[i];
    sight.joints.resize(static_cast<size_t>(joint_count));
    sight.present = !moment.poses[i].empty();
    if (!sight.present) continue;
    sight.azimuth_deg = AzimuthOf(camera, moment.trunks[i]);
    for (int j = 0; j < joint_count; ++j) {
      JointSight& joint = sight.joints[j];
      const Vector3d& point = moment.poses[i][j].position_m;
      const std::optional<Vector2d> px = camera.Project(point);
      joint.in_image = px.has_value() && SizeOf(camera).Contains(*px);
      if (!joint.in_image) continue;
      joint.px = *px;
      joint.depth_m = camera.Depth(point);
      for (size_t k = 0; k < moment.obstacles.size() && !joint.hidden; ++k) {
        joint.hidden = k != i && moment.obstacles[k].has_value() &&
                       moment.obstacles[k]->Hides(camera.centre(), point);
      }
    }
  }
  return sights;
}

}  // namespace kinegraph
