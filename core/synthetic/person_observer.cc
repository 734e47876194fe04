#include "core/synthetic/person_observer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/constants.h"

namespace kinegraph {
namespace {

using Eigen::Vector2d;

constexpr double kLeastConfidence = 0.05;

double Correlation(double time_s, double frame_rate_hz) {
  return time_s > 0.0 ? std::exp(-1.0 / (frame_rate_hz * time_s)) : 0.0;
}

bool IsArm(JointClass c) {
  return c == JointClass::kElbow || c == JointClass::kWrist;
}

bool IsBelowHips(JointClass c) {
  return c == JointClass::kKnee || c == JointClass::kAnkle ||
         c == JointClass::kFoot;
}

bool IsLowerPart(JointClass c) {
  return IsBelowHips(c) || c == JointClass::kHip;
}

bool InSwap(Swap swap, JointClass c) {
  switch (swap) {
    case Swap::kNone:
      return false;
    case Swap::kWhole:
      return true;
    case Swap::kArm:
      return IsArm(c);
    case Swap::kLeg:
      return IsBelowHips(c);
  }
  return false;
}

}  // namespace

PersonObserver::PersonObserver(const NoiseOptions& options,
                               const Skeleton& skeleton, ImageBounds image,
                               double frame_rate_hz, int view_idx,
                               int person_idx)
    : options_(options),
      skeleton_(skeleton),
      image_(image),
      frame_rate_hz_(frame_rate_hz),
      person_(person_idx),
      pixels_(StreamSeed(options.seed, Stream::kPixels, view_idx, person_idx)),
      outliers_(
          StreamSeed(options.seed, Stream::kOutliers, view_idx, person_idx)),
      missing_(
          StreamSeed(options.seed, Stream::kMissing, view_idx, person_idx)),
      confidence_(
          StreamSeed(options.seed, Stream::kConfidence, view_idx, person_idx)),
      people_(StreamSeed(options.seed, Stream::kPeople, view_idx, person_idx)),
      joints_(skeleton.joints().size()) {
  for (const std::string& joint : skeleton.joints()) {
    const auto at = options.found_by_azimuth.find(joint);
    found_by_azimuth_.push_back(
        at == options.found_by_azimuth.end() ? nullptr : &at->second);
  }
}

double PersonObserver::DepthScale(const JointNoise& noise,
                                  const JointSight& sight) const {
  if (noise.reference_depth_m <= 0.0) return 1.0;
  constexpr double kLeastDepth = 0.1;  // [m]
  return noise.reference_depth_m / std::max(sight.depth_m, kLeastDepth);
}

bool PersonObserver::Misses(int joint, const PersonSight& person) {
  const JointNoise& noise = options_.Of(skeleton_.joint_class(joint));
  double rate = noise.missing_rate;
  if (const std::vector<double>* found = found_by_azimuth_[joint]) {
    const auto bins = static_cast<double>(found->size());
    const double place = (person.azimuth_deg + 180.0) / 360.0 * bins;
    const size_t bin = static_cast<size_t>(std::clamp(place, 0.0, bins - 1.0));
    rate = 1.0 - (*found)[bin];
  }
  if (person.joints[joint].hidden) {
    rate = std::max(rate, noise.hidden_missing_rate);
  }
  return joints_[joint].missing.Step(rate, Frames(noise.missing_burst_s),
                                     &missing_);
}

PersonObserver::Displacement PersonObserver::PixelNoise(
    int joint, const JointSight& sight) {
  const JointNoise& noise = options_.Of(skeleton_.joint_class(joint));
  JointState& state = joints_[joint];
  const double rho = Correlation(noise.correlation_time_s, frame_rate_hz_);
  auto normal = [&] {
    const double x = pixels_.Normal();
    return Vector2d(x, pixels_.Normal());
  };
  if (!state.started) {
    state.started = true;
    state.fixed = normal();
  }
  const double slow_share =
      std::max(0.0, 1.0 - noise.static_share - noise.white_share);
  const Vector2d slow = state.slow.Step(rho, &pixels_);
  const Vector2d changing =
      std::sqrt(slow_share) * slow + std::sqrt(noise.white_share) * normal();
  const double tails = noise.student_dof > 0.0
                           ? state.tails.Step(rho, noise.student_dof, &pixels_)
                           : 1.0;
  const Vector2d unit =
      std::sqrt(noise.static_share) * state.fixed + tails * changing;

  // exp(s g - s^2) has unit mean square.
  const double s = options_.noise_spread;
  Displacement displacement;
  if (s > 0.0) {
    const double g = state.spread.Step(rho, &confidence_).x();
    displacement.sigma_factor = std::exp(s * g - s * s);
  }
  const double sigma_px = noise.sigma_px * DepthScale(noise, sight) *
                          displacement.sigma_factor *
                          (sight.hidden ? noise.hidden_noise_factor : 1.0);
  displacement.px = sigma_px * unit + noise.floor_px * normal();
  return displacement;
}

// The person whose same joint is nearest in the image, within the person's size
// there: detectors confuse people who overlap or stand side by side.
int PersonObserver::NearestOther(int joint,
                                 const std::vector<PersonSight>& sights) const {
  const std::vector<JointSight>& own = sights[person_].joints;
  if (!own[joint].in_image) return -1;
  double nearest = 0.0;
  for (const JointSight& other : own) {
    if (!other.in_image) continue;
    nearest = std::max(nearest, (other.px - own[joint].px).norm());
  }
  int person = -1;
  for (int i = 0; i < static_cast<int>(sights.size()); ++i) {
    if (i == person_ || !sights[i].present) continue;
    const JointSight& other = sights[i].joints[joint];
    if (!other.in_image) continue;
    const double distance = (other.px - own[joint].px).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    person = i;
  }
  return person;
}

bool PersonObserver::Outlier(int joint, const std::vector<PersonSight>& sights,
                             Vector2d* px) {
  const JointNoise& noise = options_.Of(skeleton_.joint_class(joint));
  JointState& state = joints_[joint];
  const JointSight& sight = sights[person_].joints[joint];
  const int frames =
      std::max(1, static_cast<int>(std::lround(Frames(noise.outlier_burst_s))));
  bool began = false;
  const bool on =
      state.outlier.Step(noise.outlier_rate, frames, &outliers_, &began);
  if (began) {
    const double angle = outliers_.Uniform(-kPi, kPi);
    state.displacement =
        outliers_.Uniform(noise.outlier_min_px, noise.outlier_max_px) *
        Vector2d(std::cos(angle), std::sin(angle));
    const bool on_other = outliers_.Chance(noise.outlier_on_other);
    state.other = on_other ? NearestOther(joint, sights) : -1;
  }
  if (!on) return false;
  if (state.other >= 0) {
    const PersonSight& other = sights[state.other];
    if (other.present && other.joints[joint].in_image) {
      *px += other.joints[joint].px - sight.px;
      return true;
    }
  }
  Vector2d displacement = DepthScale(noise, sight) * state.displacement;
  // A detector finds nothing outside the image.
  if (!image_.Contains(*px + displacement)) displacement = -displacement;
  *px += displacement;
  return true;
}

Keypoint PersonObserver::Measure(int joint,
                                 const std::vector<PersonSight>& sights,
                                 bool* outlier) {
  const PersonSight& person = sights[person_];
  const JointSight& sight = person.joints[joint];
  // Every process advances, whether the person is seen or not, so that time
  // passes.
  const bool misses = Misses(joint, person);
  const Displacement noise = PixelNoise(joint, sight);
  Keypoint keypoint;
  keypoint.px = sight.px + noise.px;
  *outlier = Outlier(joint, sights, &keypoint.px);
  const double chance = confidence_.Normal();
  keypoint.found = person.present && sight.in_image && !misses;
  if (!keypoint.found) {
    *outlier = false;
    return Keypoint();
  }
  double mean = options_.confidence;
  if (sight.hidden) mean *= options_.hidden_confidence_factor;
  if (*outlier) mean *= options_.outlier_confidence_factor;
  mean /= noise.sigma_factor * noise.sigma_factor;
  keypoint.confidence = std::clamp(mean + options_.confidence_sigma * chance,
                                   kLeastConfidence, 1.0);
  return keypoint;
}

Swap PersonObserver::ChooseSwap() {
  const double length = Frames(options_.swap_burst_s);
  const bool whole =
      swap_whole_.Step(options_.swap_whole_rate, length, &people_);
  const bool arm = swap_arm_.Step(options_.swap_arm_rate, length, &people_);
  const bool leg = swap_leg_.Step(options_.swap_leg_rate, length, &people_);
  if (whole) return Swap::kWhole;
  if (arm) return Swap::kArm;
  return leg ? Swap::kLeg : Swap::kNone;
}

void PersonObserver::ExchangeSides(Swap swap,
                                   LabelledDetection* labelled) const {
  std::vector<Keypoint>& joints = labelled->detection.joints;
  std::vector<int> source(joints.size());
  for (int j = 0; j < skeleton_.joint_count(); ++j) {
    source[j] =
        InSwap(swap, skeleton_.joint_class(j)) ? skeleton_.mirror(j) : j;
  }
  const std::vector<Keypoint> before = joints;
  bool changed = false;
  for (size_t j = 0; j < joints.size(); ++j) {
    const auto from = static_cast<size_t>(source[j]);
    joints[j] = before[from];
    changed = changed || (from != j && joints[j].found);
  }
  // A swap of what was not found is none.
  labelled->truth.swap = changed ? swap : Swap::kNone;
  for (int& joint : labelled->truth.outliers) joint = source[joint];
}

LabelledDetection PersonObserver::PartOf(const LabelledDetection& whole,
                                         DetectionKind kind) const {
  LabelledDetection part = whole;
  part.truth.kind = kind;
  auto outside = [&](int j) {
    return IsLowerPart(skeleton_.joint_class(j)) !=
           (kind == DetectionKind::kLowerPart);
  };
  for (int j = 0; j < skeleton_.joint_count(); ++j) {
    if (outside(j)) part.detection.joints[j] = Keypoint();
  }
  auto& outliers = part.truth.outliers;
  outliers.erase(std::remove_if(outliers.begin(), outliers.end(), outside),
                 outliers.end());
  return part;
}

// The same person found again, a little off and less complete.
LabelledDetection PersonObserver::SecondOf(const LabelledDetection& first) {
  constexpr double kSigmaPx = 3.0;
  constexpr double kKept = 0.7;
  LabelledDetection second = first;
  second.truth.kind = DetectionKind::kDouble;
  for (Keypoint& joint : second.detection.joints) {
    const double x = people_.Normal(0.0, kSigmaPx);
    const double y = people_.Normal(0.0, kSigmaPx);
    if (people_.Chance(kKept)) {
      joint.px += Vector2d(x, y);
    } else {
      joint = Keypoint();
    }
  }
  auto& outliers = second.truth.outliers;
  outliers.erase(
      std::remove_if(outliers.begin(), outliers.end(),
                     [&](int j) { return !second.detection.joints[j].found; }),
      outliers.end());
  return second;
}

void PersonObserver::Step(const std::vector<PersonSight>& sights,
                          std::vector<LabelledDetection>* detections) {
  const PersonSight& person = sights[person_];
  LabelledDetection whole;
  whole.truth.person = person_;
  int in_image = 0;
  int hidden = 0;
  for (int j = 0; j < skeleton_.joint_count(); ++j) {
    bool outlier = false;
    whole.detection.joints.push_back(Measure(j, sights, &outlier));
    if (outlier) whole.truth.outliers.push_back(j);
    in_image += person.joints[j].in_image ? 1 : 0;
    hidden += person.joints[j].in_image && person.joints[j].hidden ? 1 : 0;
  }
  const bool mostly_hidden = 2 * hidden > in_image;
  const double missed_rate =
      mostly_hidden
          ? std::max(options_.missed_rate, options_.hidden_missed_rate)
          : options_.missed_rate;
  const bool missed =
      missed_.Step(missed_rate, Frames(options_.missed_burst_s), &people_);
  const Swap swap = ChooseSwap();
  const double length = Frames(options_.fragment_burst_s);
  const bool split = fragment_.Step(options_.fragment_rate, length, &people_);
  const bool twice = double_.Step(options_.double_rate, length, &people_);

  auto enough = [&](const LabelledDetection& labelled) {
    return CountFound(labelled.detection) >=
           std::max<int64_t>(1, options_.min_joints);
  };
  if (!person.present || missed || !enough(whole)) return;
  if (swap != Swap::kNone) ExchangeSides(swap, &whole);
  if (split) {
    LabelledDetection upper = PartOf(whole, DetectionKind::kUpperPart);
    LabelledDetection lower = PartOf(whole, DetectionKind::kLowerPart);
    if (enough(upper) && enough(lower)) {
      detections->push_back(std::move(upper));
      detections->push_back(std::move(lower));
      return;
    }
  }
  if (twice) {
    LabelledDetection second = SecondOf(whole);
    if (enough(second)) detections->push_back(std::move(second));
  }
  detections->push_back(std::move(whole));
}

}  // namespace kinegraph
