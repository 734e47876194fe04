#include "core/data/observation.h"

#include <optional>

namespace kinegraph {

void MakeObservation(const Detection& detection, const std::vector<int>& map,
                     const std::vector<int>& counted, const Camera& camera,
                     int view_idx, TimeNs capture_time,
                     Observation* observation) {
  observation->view_idx = view_idx;
  observation->detection_idx = detection.index_in_file;
  observation->capture_time = capture_time;
  observation->joints.resize(map.size());
  observation->ideal_px.resize(map.size());
  const bool distorted = camera.lens() != nullptr;
  for (size_t j = 0; j < map.size(); ++j) {
    Keypoint& joint = observation->joints[j];
    joint = map[j] >= 0 ? detection.joints[map[j]] : Keypoint();
    if (!joint.found) continue;
    observation->ideal_px[j] = joint.px;
    if (distorted) {
      const std::optional<Eigen::Vector2d> ideal = camera.Undistort(joint.px);
      if (!ideal.has_value()) {
        joint.found = false;
        continue;
      }
      observation->ideal_px[j] = *ideal;
    }
  }
  observation->found_count = 0;
  double confidence_sum = 0.0;
  for (const int j : counted) {
    if (!observation->joints[j].found) continue;
    ++observation->found_count;
    confidence_sum += observation->joints[j].confidence;
  }
  observation->mean_confidence = observation->found_count > 0
                                     ? confidence_sum / observation->found_count
                                     : 0.0;
}

}  // namespace kinegraph
