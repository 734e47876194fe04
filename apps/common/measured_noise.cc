#include "apps/common/measured_noise.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/io/configuration/noise_model.h"

namespace kinegraph {
namespace {

double Scaled(double rate, double factor) {
  return std::min(1.0, rate * factor);
}

// Mean length of a run that goes on with chance `stays`.
double RunSeconds(double stays) {
  constexpr double kLongest = 1000.0;  // frames
  return std::min(kLongest, 1.0 / std::max(1.0 - stays, 1e-9)) /
         kNoiseModelFrameRate;
}

// The model's sigma is the scale of a Student core. Its static share is taken
// as Gaussian, the rest as Student of that scale, whose variance is larger by
// dof / (dof - 2).
JointNoise NoiseOf(const NoiseModelGroup& group, const NoiseModel& model,
                   const NoiseModelOptions& options, double focal_px) {
  JointNoise noise;
  const double tails = group.student_dof / (group.student_dof - 2.0);
  const double variance =
      group.static_share + (1.0 - group.static_share) * tails;
  const double scale_px = options.noise * group.sigma_m * focal_px;
  noise.sigma_px = scale_px * std::sqrt(variance);
  noise.reference_depth_m = 1.0;  // metres times focal length: px at 1 m
  noise.floor_px = options.floor_px;
  noise.student_dof = group.student_dof;
  noise.static_share = group.static_share / variance;
  const double white =
      std::max(0.0, 1.0 - group.static_share - group.slow_share);
  noise.white_share = white * tails / variance;
  noise.correlation_time_s =
      group.slow_rho > 0.0 && group.slow_rho < 1.0
          ? -1.0 / (kNoiseModelFrameRate * std::log(group.slow_rho))
          : 0.0;
  noise.outlier_rate = Scaled(group.outlier_rate, options.outliers);
  noise.outlier_burst_s = RunSeconds(group.outlier_stays);
  // Beyond 4 sigma, with the measured median.
  noise.outlier_min_px = 4.0 * scale_px;
  noise.outlier_max_px = (2.0 * group.outlier_median_sigma - 4.0) * scale_px;
  noise.outlier_on_other = model.outlier_on_other;
  noise.missing_rate = Scaled(group.missing_rate, options.missing);
  noise.missing_burst_s = RunSeconds(group.missing_stays);
  noise.hidden_missing_rate =
      Scaled(group.hidden_missing_rate, options.missing);
  noise.hidden_noise_factor =
      group.sigma_m > 0.0 ? group.hidden_sigma_m / group.sigma_m : 1.0;
  return noise;
}

// Which measured group stands for a class.
const char* GroupOf(JointClass joint_class) {
  switch (joint_class) {
    case JointClass::kHead:
    case JointClass::kOther:
      return "face";
    case JointClass::kShoulder:
      return "shoulder";
    case JointClass::kElbow:
      return "elbow";
    case JointClass::kWrist:
      return "wrist";
    case JointClass::kTrunk:
    case JointClass::kHip:
      return "hip";
    case JointClass::kKnee:
      return "knee";
    case JointClass::kAnkle:
    case JointClass::kFoot:
      break;
  }
  return "ankle";
}

}  // namespace

void ApplyNoiseModel(const std::string& path, const NoiseModelOptions& options,
                     double focal_px, NoiseOptions* noise) {
  const NoiseModel model = ReadNoiseModel(path);
  for (int c = 0; c < kJointClassCount; ++c) {
    const auto joint_class = static_cast<JointClass>(c);
    const auto group = model.groups.find(GroupOf(joint_class));
    if (group == model.groups.end()) {
      throw InputError(path, "noise",
                       std::string("no group '") + GroupOf(joint_class) + "'");
    }
    noise->by_class[joint_class] =
        NoiseOf(group->second, model, options, focal_px);
  }
  noise->found_by_azimuth = model.found_by_azimuth;
  for (auto& [joint, shares] : noise->found_by_azimuth) {
    for (double& share : shares) {
      share = 1.0 - Scaled(1.0 - share, options.missing);
    }
  }
  const auto seconds = [](double frames) {
    return frames / kNoiseModelFrameRate;
  };
  noise->confidence = model.confidence;
  noise->confidence_sigma = model.confidence_sigma;
  if (model.confidence > 0.0) {
    noise->hidden_confidence_factor =
        std::min(1.0, model.hidden_confidence / model.confidence);
    noise->outlier_confidence_factor =
        std::min(1.0, model.outlier_confidence / model.confidence);
  }
  noise->missed_rate = Scaled(model.missed_person.rate, options.missed);
  noise->missed_burst_s = seconds(model.missed_person.mean_frames);
  noise->hidden_missed_rate = Scaled(model.hidden_missed_rate, options.missed);
  noise->min_joints = 4;  // as in the detections modelled with these figures
  noise->false_people = model.false_people * options.false_people;
  noise->swap_whole_rate = Scaled(model.swap_whole.rate, options.swaps);
  noise->swap_arm_rate = Scaled(model.swap_arm.rate, options.swaps);
  noise->swap_leg_rate = Scaled(model.swap_leg.rate, options.swaps);
  noise->swap_burst_s = seconds(model.swap_whole.mean_frames);
  noise->fragment_rate = Scaled(model.fragment_rate, options.fragments);
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
