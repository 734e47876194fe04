#include "tests/support/rig.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

namespace kinegraph::testing {

CameraRig RingOfCameras(int count, double radius_m,
                        const std::vector<double>& distortion) {
  CameraRig cameras;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * M_PI * i / count;
    const Eigen::Vector3d centre(radius_m * std::cos(angle),
                                 radius_m * std::sin(angle), 2.0);
    const Eigen::Vector3d target(0.0, 0.0, 1.0);
    const Eigen::Vector3d z = (target - centre).normalized();
    const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    CameraParameters p;
    p.name = "cam" + std::to_string(i);
    p.width_px = 1920;
    p.height_px = 1080;
    p.K << 1000.0, 0.0, 960.0, 0.0, 1000.0, 540.0, 0.0, 0.0, 1.0;
    p.R.row(0) = x.transpose();
    p.R.row(1) = z.cross(x).transpose();
    p.R.row(2) = z.transpose();
    p.t = -p.R * centre;
    p.lens = MakeLens("opencv5", distortion);
    cameras.emplace_back(p);
  }
  return cameras;
}

Pose3d StandingPerson(double x_m, double y_m) {
  // COCO-17 order; +x is the person's right.
  const double joints[17][3] = {
      {0.00, 0.12, 1.65},  {-0.03, 0.10, 1.68}, {0.03, 0.10, 1.68},
      {-0.08, 0.02, 1.66}, {0.08, 0.02, 1.66},  {-0.19, 0.0, 1.42},
      {0.19, 0.0, 1.42},   {-0.24, 0.02, 1.12}, {0.24, 0.02, 1.12},
      {-0.26, 0.08, 0.86}, {0.26, 0.08, 0.86},  {-0.11, 0.0, 0.92},
      {0.11, 0.0, 0.92},   {-0.12, 0.03, 0.50}, {0.12, 0.03, 0.50},
      {-0.12, 0.0, 0.09},  {0.12, 0.0, 0.09}};
  Pose3d pose(17);
  for (int j = 0; j < 17; ++j) {
    pose[j].position_m = {joints[j][0] + x_m, joints[j][1] + y_m, joints[j][2]};
    pose[j].status = JointStatus::kObserved;
  }
  return pose;
}

Detection Project(const Pose3d& pose, const Camera& camera) {
  Detection detection;
  for (const Joint3d& joint : pose) {
    Keypoint& keypoint = detection.joints.emplace_back();
    if (!joint.present()) continue;
    const std::optional<Eigen::Vector2d> px = camera.Project(joint.position_m);
    if (!px.has_value()) continue;
    keypoint.px = *px;
    keypoint.confidence = 1.0;
    keypoint.found = true;
  }
  return detection;
}

DetectionFrame FrameSeenBy(const CameraRig& rig, int64_t frame,
                           const std::vector<Pose3d>& people, double rate_hz) {
  DetectionFrame seen;
  seen.frame = frame;
  seen.time = FrameClock(rate_hz).TimeOf(frame);
  for (const Camera& camera : rig) {
    ViewDetections& view = seen.views.emplace_back();
    view.capture_time = seen.time;
    for (const Pose3d& person : people) {
      Detection detection = Project(person, camera);
      detection.index_in_file = static_cast<int>(view.detections.size());
      view.detections.push_back(std::move(detection));
    }
  }
  return seen;
}

DetectionSequence SeenBy(
    const CameraRig& rig, int frames,
    const std::function<std::vector<Pose3d>(int)>& people) {
  DetectionSequence seen;
  seen.header.skeleton = Coco17();
  seen.header.frame_rate_hz = 25.0;
  for (const Camera& camera : rig) {
    seen.header.view_names.push_back(camera.name());
  }
  for (int f = 0; f < frames; ++f) {
    seen.frames.push_back(FrameSeenBy(rig, f, people(f)));
  }
  return seen;
}

Observation Observe(const Pose3d& pose, const CameraRig& cameras, int view_idx,
                    int detection_idx) {
  Detection detection = Project(pose, cameras[view_idx]);
  detection.index_in_file = detection_idx;
  std::vector<int> same(pose.size());
  std::iota(same.begin(), same.end(), 0);
  Observation observation;
  MakeObservation(detection, same, same, cameras[view_idx], view_idx, 0,
                  &observation);
  return observation;
}

}  // namespace kinegraph::testing
