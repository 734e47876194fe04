// Figures of a detector's faults, measured on real data
// (data/campus/detections_modelled/noise_model.json).
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_NOISE_MODEL_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_NOISE_MODEL_H_

#include <map>
#include <string>
#include <vector>

namespace kinegraph {

// Of a group of joints.
struct NoiseModelGroup {
  double sigma_m = 0.0;  // scale of the core, each axis, at the person's depth
  double hidden_sigma_m = 0.0;  // with another person in front
  double student_dof = 0.0;     // of the core
  double static_share = 0.0;    // of the variance
  double slow_share = 0.0;
  double slow_rho = 0.0;  // correlation of neighbouring frames
  double outlier_rate = 0.0;
  double outlier_median_sigma = 0.0;  // distance
  double outlier_stays = 0.0;         // chance to stay one in the next frame
  double missing_rate = 0.0;          // with nobody in front
  double hidden_missing_rate = 0.0;   // with another person in front
  double missing_stays = 0.0;
};

// Something that happens to a share of the observations, in runs.
struct NoiseModelEvent {
  double rate = 0.0;
  double mean_frames = 1.0;
};

struct NoiseModel {
  // shoulder, elbow, wrist, hip, knee, ankle, face.
  std::map<std::string, NoiseModelGroup> groups;
  // Joint to the shares found, by the camera's azimuth: equal bins from -180
  // degrees, 0 in front, +90 on the right-hand side.
  std::map<std::string, std::vector<double>> found_by_azimuth;
  NoiseModelEvent missed_person;  // not mostly hidden
  double hidden_missed_rate = 0.0;
  NoiseModelEvent swap_whole;
  NoiseModelEvent swap_arm;
  NoiseModelEvent swap_leg;
  double false_people = 0.0;   // mean number per image
  double fragment_rate = 0.0;  // further detections per person-view
  double outlier_on_other = 0.0;
  double confidence = 0.0;  // means
  double confidence_sigma = 0.0;
  double hidden_confidence = 0.0;
  double outlier_confidence = 0.0;
};

// Frame rate at which the file's figures per frame hold [Hz].
inline constexpr double kNoiseModelFrameRate = 25.0;

// Throws InputError naming file and key.
NoiseModel ReadNoiseModel(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_NOISE_MODEL_H_
