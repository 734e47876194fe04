#include <string>

#include "core/base/error.h"
#include "core/synthetic/noise.h"

namespace kinegraph {
namespace {

constexpr double kMaxOffset = 1.0;  // of a clock [s]; kSceneMargin covers it

void CheckJointNoise(const std::string& key, const JointNoise& noise) {
  CheckOptions(noise);
  if (noise.static_share + noise.white_share > 1.0) {
    throw OptionError(key + "static_share",
                      "static_share and white_share add up to more than 1");
  }
  if (noise.outlier_min_px > noise.outlier_max_px) {
    throw OptionError(key + "outlier_min", "is above outlier_max");
  }
  if (noise.student_dof != 0.0 && noise.student_dof <= 2.0) {
    throw OptionError(key + "student_dof",
                      "found " + std::to_string(noise.student_dof) +
                          ", expected 0 (Gaussian) or more than 2");
  }
}

}  // namespace

void JointNoise::Describe(OptionVisitor& visitor) {
  const Limits share = Between(0.0, 1.0);
  const Limits length = Between(0.0, 1e6);
  visitor.Number("sigma", &sigma_px, NonNegative(), "px",
                 "standard deviation of each pixel coordinate");
  visitor.Number("reference_depth", &reference_depth_m, NonNegative(), "m",
                 "depth to which values in pixels refer; they scale with "
                 "1/depth; 0: the same at every depth");
  visitor.Number("floor", &floor_px, NonNegative(), "px",
                 "white noise added at every depth");
  visitor.Number("student_dof", &student_dof, Between(0.0, 1e6), "",
                 "degrees of freedom of Student-t tails, above 2; 0: Gaussian");
  visitor.Number("static_share", &static_share, share, "",
                 "share of the variance that is constant over the recording");
  visitor.Number("white_share", &white_share, share, "",
                 "share of the variance that is independent between frames");
  visitor.Number("correlation_time", &correlation_time_s, length, "s",
                 "correlation time of the remaining variance; 0: white");
  visitor.Number("outlier_rate", &outlier_rate, share, "",
                 "share of joints with a gross error");
  visitor.Number("outlier_burst", &outlier_burst_s, length, "s",
                 "exact length of a run of outliers; 0: independent frames");
  visitor.Number("outlier_min", &outlier_min_px, NonNegative(), "px",
                 "least distance of an outlier");
  visitor.Number("outlier_max", &outlier_max_px, NonNegative(), "px",
                 "greatest distance of an outlier");
  visitor.Number("outlier_on_other", &outlier_on_other, share, "",
                 "share of outliers on the same joint of a person nearby");
  visitor.Number("missing_rate", &missing_rate, share, "",
                 "share of joints that are not found");
  visitor.Number("missing_burst", &missing_burst_s, length, "s",
                 "mean length of a gap; 0: independent frames");
  visitor.Number("hidden_missing_rate", &hidden_missing_rate, share, "",
                 "share of joints not found where another body is in front");
  visitor.Number("hidden_noise_factor", &hidden_noise_factor,
                 Between(0.0, 100.0), "",
                 "factor on sigma where another body is in front");
}

const JointNoise& NoiseOptions::Of(JointClass joint_class) const {
  const auto at = by_class.find(joint_class);
  return at == by_class.end() ? joints : at->second;
}

void NoiseOptions::Check(size_t cameras) const {
  CheckOptions(*this);
  CheckJointNoise("", joints);
  for (const auto& [joint_class, noise] : by_class) {
    CheckJointNoise(std::string(ToString(joint_class)) + ".", noise);
  }
  if (clock_offset_s.size() > cameras) {
    throw OptionError("clock_offset",
                      "found " + std::to_string(clock_offset_s.size()) +
                          " numbers for " + std::to_string(cameras) +
                          " cameras");
  }
}

void NoiseOptions::Describe(OptionVisitor& visitor) {
  const Limits share = Between(0.0, 1.0);
  const Limits length = Between(0.0, 1e6);
  visitor.Integer("seed", &seed, Between(0, 9e15), "", "same seed, same noise");
  joints.Describe(visitor);
  visitor.Number(
      "confidence", &confidence, share, "",
      "mean confidence of a joint that is visible and not an outlier");
  visitor.Number("confidence_sigma", &confidence_sigma, share, "",
                 "standard deviation of the random part of the confidence");
  visitor.Number(
      "noise_spread", &noise_spread, Between(0.0, 2.0), "",
      "standard deviation of log sigma, which the confidence reflects");
  visitor.Number("missed_rate", &missed_rate, share, "",
                 "share of people not found in a view");
  visitor.Number("missed_burst", &missed_burst_s, length, "s",
                 "mean length of a miss; 0: independent frames");
  visitor.Number("hidden_missed_rate", &hidden_missed_rate, share, "",
                 "share of people not found when most joints are hidden");
  visitor.Integer("min_joints", &min_joints, Between(1, 1000), "",
                  "people with fewer found joints are not detected");
  visitor.Number("false_people", &false_people, Between(0.0, 50.0), "",
                 "mean number of false detections per image");
  visitor.Number("swap_whole_rate", &swap_whole_rate, share, "",
                 "share of detections with left and right exchanged");
  visitor.Number("swap_arm_rate", &swap_arm_rate, share, "",
                 "share of detections with only elbows and wrists exchanged");
  visitor.Number(
      "swap_leg_rate", &swap_leg_rate, share, "",
      "share of detections with only knees, ankles and feet exchanged");
  visitor.Number("swap_burst", &swap_burst_s, length, "s",
                 "mean length of an exchange; 0: independent frames");
  visitor.Number("fragment_rate", &fragment_rate, share, "",
                 "share of people split at the hips into two detections");
  visitor.Number("double_rate", &double_rate, share, "",
                 "share of people found twice");
  visitor.Number("fragment_burst", &fragment_burst_s, length, "s",
                 "mean length of splitting or doubling; 0: independent frames");
  visitor.Number("dropped_frame_rate", &dropped_frame_rate, Between(0.0, 0.99),
                 "", "share of frames that are missing");
  visitor.Number("dropped_view_rate", &dropped_view_rate, share, "",
                 "share of images without any detection");
  visitor.Number(
      "drop_burst", &drop_burst_s, length, "s",
      "mean length of a run of missing frames or empty images; 0: independent");
  visitor.NumberList("clock_offset", &clock_offset_s,
                     Between(-kMaxOffset, kMaxOffset), "s",
                     "how much later each camera captures; 0 if not listed");
  visitor.Number("time_jitter", &time_jitter_s, Between(0.0, 0.1), "s",
                 "standard deviation of the times of frames");
  visitor.Boolean("tell_times", &tell_times,
                  "times include offset and jitter; else they are nominal");
}

std::string NoteOf(const DetectionTruth& truth) {
  static constexpr const char* kSwaps[] = {"", "swap_whole", "swap_arm",
                                           "swap_leg"};
  static constexpr const char* kKinds[] = {
      "", "fragment_upper", "fragment_lower", "double", "false_positive"};
  std::string note = kSwaps[static_cast<size_t>(truth.swap)];
  const char* kind = kKinds[static_cast<size_t>(truth.kind)];
  if (!note.empty() && *kind != '\0') note += '+';
  return note + kind;
}

}  // namespace kinegraph
