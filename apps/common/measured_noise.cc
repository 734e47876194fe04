#include "apps/common/measured_noise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

// Frame rate to which the file's values per frame refer [Hz].
constexpr double kFrameRateHz = 25.0;

double NumberWithin(const JsonField& parent, const std::string& key, double low,
                    double high) {
  const JsonField field = parent.At(key);
  const double value = field.Number();
  if (value < low || value > high) {
    field.FailExpected("a number from " + std::to_string(low) + " to " +
                       std::to_string(high));
  }
  return value;
}

double ReadShare(const JsonField& parent, const std::string& key) {
  return NumberWithin(parent, key, 0.0, 1.0);
}

double Size(const JsonField& parent, const std::string& key) {
  return NumberWithin(parent, key, 0.0, 1e6);
}

double Scaled(double rate, double factor) {
  return std::min(1.0, rate * factor);
}

// Mean length of a run that continues with probability `stays`.
double RunSeconds(double stays) {
  constexpr double kLongest = 1000.0;  // frames
  return std::min(kLongest, 1.0 / std::max(1.0 - stays, 1e-9)) / kFrameRateHz;
}

// An event that affects a share of the observations, in runs.
struct Event {
  double rate = 0.0;
  double mean_s = 0.0;
};

Event ReadEvent(const JsonField& parent, const std::string& rate) {
  return {ReadShare(parent, rate),
          Size(parent, "run_length_mean") / kFrameRateHz};
}

// The noise of a group of joints. The model's sigma is the scale of a Student
// core on each axis, at the person's depth. Its static share is assumed to be
// Gaussian, the rest Student of that scale, whose variance is larger by dof /
// (dof - 2).
JointNoise ReadGroup(const JsonField& field, const JsonField& missing,
                     double outlier_on_other, const NoiseModelOptions& options,
                     double focal_px) {
  JointNoise noise;
  const double sigma_m = Size(field, "sigma_m_per_axis");
  const double hidden_sigma_m = Size(field, "sigma_if_other_person_in_front");
  noise.student_dof = NumberWithin(field, "student_t_dof_of_core", 2.01, 1e6);
  const double static_share = ReadShare(field, "static_share");
  const double slow_share = ReadShare(field, "slow_share");
  const double slow_rho = ReadShare(field, "slow_rho_per_frame");
  const double tails = noise.student_dof / (noise.student_dof - 2.0);
  const double variance = static_share + (1.0 - static_share) * tails;
  const double scale_px = options.noise * sigma_m * focal_px;
  noise.sigma_px = scale_px * std::sqrt(variance);
  // Scale is in metres times focal length: px at 1 m.
  noise.reference_depth_m = 1.0;
  noise.floor_px = options.floor_px;
  noise.static_share = static_share / variance;
  const double white = std::max(0.0, 1.0 - static_share - slow_share);
  noise.white_share = white * tails / variance;
  noise.correlation_time_s = slow_rho > 0.0 && slow_rho < 1.0
                                 ? -1.0 / (kFrameRateHz * std::log(slow_rho))
                                 : 0.0;
  noise.outlier_rate =
      Scaled(ReadShare(field, "p_outlier_over_4_sigma"), options.outliers);
  // Uniform from 4 sigma on, such that the median is the measured one.
  noise.outlier_min_px = 4.0 * scale_px;
  noise.outlier_max_px =
      (2.0 * NumberWithin(field, "outlier_median_in_sigma", 4.0, 1e3) - 4.0) *
      scale_px;
  noise.outlier_burst_s = RunSeconds(ReadShare(field, "p_outlier_stays"));
  noise.outlier_on_other = outlier_on_other;
  noise.missing_rate =
      Scaled(ReadShare(missing, "p_missing_if_not"), options.missing);
  noise.hidden_missing_rate =
      Scaled(ReadShare(missing, "p_missing_if_other_person_in_front"),
             options.missing);
  noise.missing_burst_s = RunSeconds(ReadShare(missing, "p_stay_missing"));
  noise.hidden_noise_factor = sigma_m > 0.0 ? hidden_sigma_m / sigma_m : 1.0;
  return noise;
}

// For each joint, the probability of being found, by the camera's azimuth; the
// miss rate is multiplied by `missing`. The entry "bins" describes the bins of
// azimuth.
std::map<std::string, std::vector<double>> ReadAzimuths(const JsonField& table,
                                                        double missing) {
  std::map<std::string, std::vector<double>> found;
  for (const auto& [joint, field] : table.Members("joint")) {
    if (joint == "bins") continue;
    std::vector<double> shares = field.Numbers();
    if (shares.empty()) field.FailExpected("at least one share");
    for (double& share : shares) {
      if (share < 0.0 || share > 1.0) field.FailExpected("shares from 0 to 1");
      share = 1.0 - Scaled(1.0 - share, missing);
    }
    found[joint] = shares;
  }
  return found;
}

// The measured group used for each class, in the order of JointClass.
constexpr const char* kGroups[kJointClassCount] = {
    "face", "hip",  "shoulder", "elbow", "wrist",
    "hip",  "knee", "ankle",    "ankle", "face"};

}  // namespace

void ApplyNoiseModel(const std::string& path, const NoiseModelOptions& options,
                     double focal_px, NoiseOptions* noise) {
  const Json json = ParseJson(ReadTextFile(path, kMaxSmallFileBytes), path);
  const JsonField root(json, path);
  const JsonField missing = root.At("missing_joint");
  const double outlier_on_other =
      ReadShare(root.At("outlier_on_other_persons_same_joint"), "share");
  std::map<std::string, JointNoise> groups;
  for (const auto& [name, field] : root.At("noise").Members("group")) {
    groups[name] =
        ReadGroup(field, missing.At(name), outlier_on_other, options, focal_px);
  }
  for (int c = 0; c < kJointClassCount; ++c) {
    const auto group = groups.find(kGroups[c]);
    if (group == groups.end()) {
      throw InputError(path, "noise",
                       std::string("no group '") + kGroups[c] + "'");
    }
    noise->by_class[static_cast<JointClass>(c)] = group->second;
  }
  noise->found_by_azimuth =
      ReadAzimuths(root.At("face_found_by_camera_azimuth"), options.missing);
  const JsonField confidence = root.At("confidence");
  const double plain = ReadShare(confidence.At("plain"), "mean");
  const double hidden =
      ReadShare(confidence.At("other_person_in_front"), "mean");
  const double wrong = ReadShare(confidence.At("outlier"), "mean");
  noise->confidence = plain;
  noise->confidence_sigma = ReadShare(confidence.At("plain"), "sd");
  if (plain > 0.0) {
    noise->hidden_confidence_factor = std::min(1.0, hidden / plain);
    noise->outlier_confidence_factor = std::min(1.0, wrong / plain);
  }
  const JsonField missed = root.At("missed_person");
  const Event one_missed = ReadEvent(missed, "p_missed_if_not");
  noise->missed_rate = Scaled(one_missed.rate, options.missed);
  noise->missed_burst_s = one_missed.mean_s;
  noise->hidden_missed_rate =
      Scaled(ReadShare(missed, "p_missed_if_mostly_hidden"), options.missed);
  noise->min_joints = 4;  // as in the measurement
  noise->false_people =
      Size(root.At("false_positive_person"), "mean_per_image") *
      options.false_people;
  const JsonField swaps = root.At("left_right_swap");
  const Event whole = ReadEvent(swaps.At("whole"), "p");
  const Event arm = ReadEvent(swaps.At("arm"), "p");
  const Event leg = ReadEvent(swaps.At("leg"), "p");
  noise->swap_whole_rate = Scaled(whole.rate, options.swaps);
  noise->swap_arm_rate = Scaled(arm.rate, options.swaps);
  noise->swap_leg_rate = Scaled(leg.rate, options.swaps);
  noise->swap_burst_s = whole.mean_s;
  noise->fragment_rate =
      Scaled(ReadShare(root.At("fragment"), "mean_per_person_view"),
             options.fragments);
}

void NoiseModelOptions::Describe(OptionVisitor& visitor) {
  const Limits factor = Between(0.0, 100.0);
  visitor.Text("file", &file,
               "noise_model.json with measured figures, relative to this "
               "file's folder");
  visitor.Number("noise", &noise, factor, "", "factor on pixel noise");
  visitor.Number("floor", &floor_px, NonNegative(), "px",
                 "white noise added at every depth");
  visitor.Number("outliers", &outliers, factor, "", "factor on their rate");
  visitor.Number("missing", &missing, factor, "",
                 "factor on the rate of missing joints");
  visitor.Number("missed", &missed, factor, "",
                 "factor on the rate of missed people");
  visitor.Number("swaps", &swaps, factor, "", "factor on their rate");
  visitor.Number("false_people", &false_people, factor, "",
                 "factor on their number");
  visitor.Number("fragments", &fragments, factor, "", "factor on their rate");
}

}  // namespace kinegraph
