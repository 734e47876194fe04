#include "solvers/noise/bone_spreads.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/weighted_quantile.h"

namespace kinegraph {
namespace {

double Square(double x) { return x * x; }

// A length estimated from observations, and the deviation of each.
struct LengthFit {
  bool known = false;
  // true: a median of lengths; false, with large noise: a mean of squared
  // lengths.
  bool is_median = true;
  double length_m = 0.0;
  // Negative if observations vary less than their noise predicts.
  double spread_m2 = 0.0;
  double noise_m2 = 0.0;           // mean variance of an observed length
  double variance_m2 = 0.0;        // the same including the spread
  std::vector<double> deviations;  // of the observations, in sigmas
};

// Weighted quantile of the values that `of` extracts from observations.
template <typename Of>
double QuantileOf(const std::vector<BoneObservation>& looks, double share,
                  const Of& of) {
  std::vector<WeightedValue> values;
  values.reserve(looks.size());
  std::transform(looks.begin(), looks.end(), std::back_inserter(values), of);
  return WeightedQuantile(std::move(values), share);
}

// Upper quartile of chi-square with one degree of freedom.
constexpr double kUpperQuartile = 1.3233;
// The 0.3 quantile of chi-square (Wilson and Hilferty 1931), accurate to 2 %
// from one degree of freedom on.
double LowChiSquare(int freedom) {
  constexpr double kNormal = -0.5244;  // 0.3 quantile of the standard normal
  const double spread = 2.0 / (9.0 * freedom);
  const double root = 1.0 - spread + kNormal * std::sqrt(spread);
  return freedom * root * root * root;
}

// Factor of the variance of the modelled noise, from the residuals.
double NoiseScale(const std::vector<BoneObservation>& looks) {
  return std::max(1e-6, QuantileOf(looks, 0.3, [](const BoneObservation& look) {
                    return WeightedValue(
                        look.square / LowChiSquare(look.freedom), look.freedom);
                  }));
}

double Length(const BoneObservation& look, double scale) {
  return look.distance_m - scale * look.added_m;
}

// Keeps the variance of exact observations above zero [m^2].
constexpr double kLeastVariance = 1e-8;

// Upper quartile of the observations' squared deviations for a spread of
// variance `spread`.
double UpperQuartile(const std::vector<BoneObservation>& looks, double scale,
                     double length_m, double spread) {
  std::vector<double> values;
  values.reserve(looks.size());
  for (const BoneObservation& look : looks) {
    values.push_back(Square(Length(look, scale) - length_m) /
                     (scale * look.variance_m2 + spread + kLeastVariance));
  }
  const auto at = static_cast<std::ptrdiff_t>(
      std::ceil(0.75 * static_cast<double>(values.size())) - 1.0);
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[at];
}

// For a bone much longer than the noise: alternates between length and spread,
// which are nearly independent.
LengthFit FitMedianLength(const std::vector<BoneObservation>& looks,
                          double scale) {
  LengthFit fit;
  fit.known = true;
  double spread = 0.0;   // variance
  double missing = 0.0;  // fraction by which the noise is overestimated
  for (int round = 0; round < 3; ++round) {
    fit.length_m = QuantileOf(looks, 0.5, [&](const BoneObservation& look) {
      return WeightedValue(
          Length(look, scale),
          1.0 / (scale * look.variance_m2 + spread + kLeastVariance));
    });
    double low = 0.0;
    double high = 0.25;  // half a metre, squared
    const double without = UpperQuartile(looks, scale, fit.length_m, low);
    if (without <= kUpperQuartile) {
      spread = 0.0;
      missing = 1.0 - without / kUpperQuartile;
      continue;
    }
    missing = 0.0;
    constexpr int kHalvings = 30;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (UpperQuartile(looks, scale, fit.length_m, middle) > kUpperQuartile
           ? low
           : high) = middle;
    }
    spread = high;
  }
  double information = 0.0;
  for (const BoneObservation& look : looks) {
    const double variance = scale * look.variance_m2 + spread + kLeastVariance;
    fit.deviations.push_back((Length(look, scale) - fit.length_m) /
                             std::sqrt(variance));
    information += 1.0 / variance;
  }
  fit.variance_m2 = static_cast<double>(looks.size()) / information;
  fit.noise_m2 = fit.variance_m2 - spread;
  fit.spread_m2 = spread - missing * fit.variance_m2;
  return fit;
}

// For a bone not much longer than the noise. |d|^2 - tr N of an observed vector
// d between the ends has the variance 4 L^2 v + 2 tr N^2 around L^2, with N the
// covariance of the noise and v its variance along the bone.
LengthFit FitSquaredLength(const std::vector<BoneObservation>& looks,
                           double scale) {
  constexpr double kFar = 4.0;  // sigmas
  std::vector<WeightedValue> values;
  values.reserve(looks.size());
  for (const BoneObservation& look : looks) {
    values.emplace_back(Square(look.distance_m) - scale * look.noise_m2, 1.0);
  }
  // Starts with the median, which lies below the required mean.
  double square_m2 = WeightedQuantile(values, 0.5);
  std::vector<double> variances_m4(looks.size());
  for (int round = 0; round < 5; ++round) {
    double information = 0.0;
    double sum = 0.0;
    for (size_t i = 0; i < looks.size(); ++i) {
      variances_m4[i] =
          4.0 * std::max(0.0, square_m2) * scale * looks[i].variance_m2 +
          2.0 * scale * scale * looks[i].noise_square_m4 +
          Square(kLeastVariance);
      const double far = kFar * std::sqrt(variances_m4[i]);
      const double seen =
          std::clamp(values[i].first, square_m2 - far, square_m2 + far);
      information += 1.0 / variances_m4[i];
      sum += seen / variances_m4[i];
    }
    square_m2 = sum / information;
  }
  LengthFit fit;
  fit.is_median = false;
  fit.length_m = std::sqrt(std::max(0.0, square_m2));
  if (!(fit.length_m > 0.0)) return fit;
  fit.known = true;
  double information = 0.0;
  for (size_t i = 0; i < looks.size(); ++i) {
    fit.deviations.push_back((values[i].first - square_m2) /
                             std::sqrt(variances_m4[i]));
    information += 1.0 / (variances_m4[i] / (4.0 * square_m2));
  }
  fit.variance_m2 = static_cast<double>(looks.size()) / information;
  fit.noise_m2 = fit.variance_m2;
  return fit;
}

// Whether noise may lengthen the bone by more than a twentieth (at most by
// tr N / (2 L)); beyond that the second-order expansion is insufficient.
bool IsNoisy(const std::vector<BoneObservation>& looks, double scale) {
  constexpr double kMost = 0.1;  // tr N / L^2
  const double noise = QuantileOf(looks, 0.5, [&](const BoneObservation& look) {
    return WeightedValue(scale * look.noise_m2, 1.0);
  });
  const double square = QuantileOf(looks, 0.5, [](const BoneObservation& look) {
    return WeightedValue(Square(look.distance_m), 1.0);
  });
  return noise > kMost * (square - noise);
}

// Undetermined if observed lengths do not exceed their noise. See BoneSpreads
// for the choice of model. `looks` must not be empty.
LengthFit FitLength(const std::vector<BoneObservation>& looks) {
  const double scale = NoiseScale(looks);
  return IsNoisy(looks, scale) ? FitSquaredLength(looks, scale)
                               : FitMedianLength(looks, scale);
}

// People differ by a tenth, and detectors' joints differ from anatomical
// joints.
constexpr double kPopulationShare = 0.15;
// Difference between left and right, for one person and detector [m].
constexpr double kAsymmetry = 0.01;
// Observations required for a bone without a population length.
constexpr int64_t kEnough = 25;
// A length whose relative variation exceeds this carries no information beyond
// the motion model.
constexpr double kGivesWay = 0.2;

// Variance of the logarithm of a scale found from the upper quartile of N
// values of chi-square with one degree of freedom, times N: p (1 - p) / (x
// f(x))^2 with p = 0.75, x = 1.3233, f the density.
constexpr double kQuartileVariance = 3.34;
// Variance of a median of N Gaussian values, times N, relative to that of a
// mean.
constexpr double kMedianVariance = 1.571;

// Effective numbers of independent observations for a mean and for a variance,
// because consecutive observations are correlated.
struct Worth {
  double of_mean = 1.0;
  double of_square = 1.0;
};

Worth WorthOf(const std::vector<double>& deviations) {
  double product = 0.0;
  double square = 0.0;
  double previous = 0.0;
  for (const double deviation : deviations) {
    // Outliers would hide the correlation.
    const double z = std::clamp(deviation, -3.0, 3.0);
    product += z * previous;
    square += z * z;
    previous = z;
  }
  const auto count = static_cast<double>(deviations.size());
  const double rho =
      square > 0.0 ? std::clamp(product / square, 0.0, 0.99) : 0.0;
  return {std::max(1.0, count * (1.0 - rho) / (1.0 + rho)),
          std::max(1.0, count * (1.0 - rho * rho) / (1.0 + rho * rho))};
}

// Variance of the mean over a time T of errors with the correlation exp(-|dt| /
// tau), relative to the variance of a single error; x = T / tau.
double MeanOfLasting(double x) {
  constexpr double kShort = 1e-3;
  if (x < kShort) return 1.0;
  return 2.0 / x - 2.0 * (1.0 - std::exp(-x)) / (x * x);
}

// The same bone on the other side, among the first `end` bones, or -1.
int MirrorOf(const Skeleton& skeleton, const std::vector<Bone>& bones,
             size_t bone_idx, size_t end) {
  const int a = skeleton.mirror(bones[bone_idx].a);
  const int b = skeleton.mirror(bones[bone_idx].b);
  int mirror = -1;
  for (size_t i = 0; i < end; ++i) {
    if (i != bone_idx && SameBone(bones[i], a, b)) mirror = static_cast<int>(i);
  }
  return mirror;
}

}  // namespace

BoneSpreads::BoneSpreads(const Skeleton& skeleton)
    : bones_(RigidPairs(skeleton)),
      seen_(bones_.size()),
      summaries_(bones_.size()) {
  for (size_t i = 0; i < bones_.size(); ++i) {
    mirror_.push_back(MirrorOf(skeleton, bones_, i, bones_.size()));
    population_m_.push_back(PopulationLength(skeleton, bones_[i]));
  }
}

void BoneSpreads::Add(int bone_idx, const BoneObservation& look) {
  Seen& seen = seen_[bone_idx];
  if (seen.count++ % seen.stride != 0) return;
  if (seen.looks.size() == kMaxLooks) {
    for (size_t i = 0; 2 * i < seen.looks.size(); ++i) {
      seen.looks[i] = seen.looks[2 * i];
    }
    seen.looks.resize(kMaxLooks / 2);
    seen.stride *= 2;
    if ((seen.count - 1) % seen.stride != 0) return;
  }
  seen.looks.push_back(look);
}

void BoneSpreads::AddFrame(const std::vector<std::optional<BoneEnd>>& ends) {
  for (size_t i = 0; i < bones_.size(); ++i) {
    const auto& a = ends[static_cast<size_t>(bones_[i].a)];
    const auto& b = ends[static_cast<size_t>(bones_[i].b)];
    if (!a.has_value() || !b.has_value()) continue;
    const auto look = LookAtBone(*a, *b);
    if (look.has_value()) Add(static_cast<int>(i), *look);
  }
}

const BoneSpreads::Summary& BoneSpreads::SummaryOf(int bone_idx) const {
  const Seen& seen = seen_[bone_idx];
  Summary& summary = summaries_[bone_idx];
  if (seen.looks.empty() || 10 * seen.count < 11 * summary.at_count) {
    return summary;
  }
  summary.at_count = seen.count;
  summary.averaged_frames =
      QuantileOf(seen.looks, 0.5, [](const BoneObservation& look) {
        return WeightedValue(look.averaged_frames, 1.0);
      });
  const LengthFit fit = FitLength(seen.looks);
  summary.known = fit.known;
  if (!fit.known) return summary;
  const Worth worth = WorthOf(fit.deviations);
  const double share = std::sqrt(kQuartileVariance / worth.of_square);
  summary.length_m = fit.length_m;
  summary.length_variance_m2 =
      (fit.is_median ? kMedianVariance : 1.0) * fit.variance_m2 / worth.of_mean;
  summary.noise_m2 = fit.noise_m2;
  summary.spread_variance_m2 = fit.spread_m2;
  summary.spread_error_m2 = fit.variance_m2 * share;
  summary.rigid_error_m2 = fit.noise_m2 * share;
  return summary;
}

// The deviations reflect errors whose correlation time is well below the
// duration of the recording; more persistent errors shift all observations
// alike and are accounted for here.
double BoneSpreads::LengthVariance(const Summary& summary) const {
  if (!(lasting_.share > 0.0)) return summary.length_variance_m2;
  const double seen_s = static_cast<double>(summary.at_count) * frame_s_;
  return std::max(summary.length_variance_m2,
                  summary.noise_m2 * lasting_.share *
                      MeanOfLasting(seen_s / lasting_.time_s));
}

BoneSpreads::Pool BoneSpreads::PooledSpread() const {
  double weights = 0.0;
  double squares = 0.0;  // of the weights
  double sum = 0.0;
  std::vector<const Summary*> known;
  for (size_t i = 0; i < bones_.size(); ++i) {
    const Summary& summary = SummaryOf(static_cast<int>(i));
    if (!summary.known) continue;
    known.push_back(&summary);
    const double weight = 1.0 / Square(summary.rigid_error_m2);
    weights += weight;
    squares += weight * weight;
    sum += weight * summary.spread_variance_m2;
  }
  Pool pool;
  pool.bones = static_cast<int>(known.size());
  if (pool.bones < 2) return pool;
  const double mean = sum / weights;
  double scatter = 0.0;
  for (const Summary* summary : known) {
    scatter +=
        Square((summary->spread_variance_m2 - mean) / summary->rigid_error_m2);
  }
  pool.between = std::max(
      0.0, (scatter - (pool.bones - 1)) / (weights - squares / weights));
  weights = sum = 0.0;
  for (const Summary* summary : known) {
    const double weight =
        1.0 / (Square(summary->rigid_error_m2) + pool.between);
    weights += weight;
    sum += weight * summary->spread_variance_m2;
  }
  pool.mean_m2 = sum / weights;
  pool.mean_variance = 1.0 / weights;
  return pool;
}

void BoneSpreads::SetSpread(const Summary& seen, BoneEstimate* estimate) const {
  double spread = seen.spread_variance_m2;
  double variance = Square(seen.spread_error_m2);
  const Pool pool = PooledSpread();
  if (pool.bones > 1) {
    const double own =
        pool.between / (pool.between + Square(seen.rigid_error_m2));
    spread = pool.mean_m2 + own * (spread - pool.mean_m2);
    variance = own * variance + Square(1.0 - own) * pool.mean_variance;
  }
  spread = std::max(0.0, spread);
  estimate->spread_m = std::sqrt(spread);
  estimate->spread_bound_m = std::sqrt(spread + std::sqrt(variance));
  estimate->averaged_frames = seen.averaged_frames;
}

std::optional<BoneEstimate> BoneSpreads::Estimate(int bone_idx) const {
  const auto at = static_cast<size_t>(bone_idx);
  const std::optional<double>& population_m = population_m_[at];
  const Summary& own = SummaryOf(bone_idx);
  const Summary* mirror = mirror_[at] >= 0 ? &SummaryOf(mirror_[at]) : nullptr;
  if (mirror != nullptr && !mirror->known) mirror = nullptr;

  double information = 0.0;
  double sum = 0.0;
  const auto add = [&](double length_m, double variance_m2) {
    information += 1.0 / variance_m2;
    sum += length_m / variance_m2;
  };
  if (population_m.has_value()) {
    const double sigma = kPopulationShare * *population_m;
    add(*population_m, sigma * sigma);
  }
  if (own.known) add(own.length_m, LengthVariance(own));
  if (mirror != nullptr) {
    add(mirror->length_m, LengthVariance(*mirror) + kAsymmetry * kAsymmetry);
  }
  int64_t looks = seen_[at].count;
  if (mirror != nullptr) looks += seen_[mirror_[at]].count;
  if (!population_m.has_value() && looks < kEnough) return std::nullopt;
  if (!(information > 0.0)) return std::nullopt;  // no longer than the noise
  BoneEstimate estimate;
  estimate.length_m = sum / information;
  estimate.length_sigma_m = std::sqrt(1.0 / information);
  // If neither side was seen, only the population's uncertainty applies.
  const Summary* seen = own.known ? &own : mirror;
  if (seen != nullptr) {
    SetSpread(*seen, &estimate);
    estimate.gives_way =
        seen->spread_variance_m2 > Square(kGivesWay * estimate.length_m);
  }
  return estimate;
}

BoneConstraint ConstraintOf(const Bone& bone, const BoneEstimate& estimate,
                            BoneUse use) {
  BoneConstraint constraint;
  constraint.a = bone.a;
  constraint.b = bone.b;
  constraint.length_m = estimate.length_m;
  const double spread_m2 = Square(estimate.spread_m);
  const double hidden_m2 = Square(estimate.spread_bound_m) - spread_m2;
  const double frames = estimate.averaged_frames;
  const double length_m2 = Square(estimate.length_sigma_m) *
                           (use == BoneUse::kCovariance ? frames : 1.0);
  constraint.sigma_m =
      std::sqrt(frames * spread_m2 + std::sqrt(frames) * hidden_m2 + length_m2);
  return constraint;
}

BoneLengths::BoneLengths(const Skeleton& skeleton)
    : bones_(RigidPairs(skeleton)) {
  for (size_t i = 0; i < bones_.size(); ++i) {
    const int earlier = MirrorOf(skeleton, bones_, i, i);
    counted_as_.push_back(earlier < 0 ? i : counted_as_[earlier]);
    population_m_.push_back(PopulationLength(skeleton, bones_[i]));
  }
  seen_.resize(bones_.size());
}

void BoneLengths::Add(int bone_idx, double distance_m, double duration_s) {
  if (!(distance_m >= 0.0)) return;
  const double bin = distance_m / kBin;
  if (bin >= kBinCount) return;
  Seen& seen = seen_[counted_as_[bone_idx]];
  seen.seconds.resize(kBinCount);
  seen.seconds[static_cast<int>(bin)] += static_cast<float>(duration_s);
  seen.total_s += duration_s;
}

void BoneLengths::AddPose(const Pose3d& pose, double duration_s) {
  for (size_t i = 0; i < bones_.size(); ++i) {
    const Joint3d& a = pose[bones_[i].a];
    const Joint3d& b = pose[bones_[i].b];
    if (a.status != JointStatus::kObserved ||
        b.status != JointStatus::kObserved) {
      continue;
    }
    Add(static_cast<int>(i), (a.position_m - b.position_m).norm(), duration_s);
  }
}

std::vector<KnownBone> BoneLengths::Known() const {
  std::vector<KnownBone> known;
  for (size_t i = 0; i < bones_.size(); ++i) {
    const std::optional<double> length_m = Length(static_cast<int>(i));
    if (length_m.has_value()) known.push_back({bones_[i], *length_m});
  }
  return known;
}

std::optional<double> BoneLengths::Length(int bone_idx) const {
  // Observations within kLook, twice the typical correlation time of a
  // detector's errors, count as one independent observation with the accuracy
  // kLookSigma.
  constexpr double kLook = 0.2;           // s
  constexpr double kLookSigma = 0.04;     // m
  constexpr double kEnoughSeconds = 1.0;  // without a population's length
  const Seen& seen = seen_[counted_as_[bone_idx]];
  const std::optional<double>& population_m = population_m_[bone_idx];
  if (!population_m.has_value() && seen.total_s < kEnoughSeconds) {
    return std::nullopt;
  }
  if (seen.total_s <= 0.0) return population_m;
  const double median_m =
      BinnedQuantile(seen.seconds, seen.total_s, 0.5) * kBin;
  if (!population_m.has_value()) return median_m;
  const double information = seen.total_s / kLook / (kLookSigma * kLookSigma);
  const double sigma_m = kPopulationShare * *population_m;
  const double prior = 1.0 / (sigma_m * sigma_m);
  return (information * median_m + prior * *population_m) /
         (information + prior);
}

PersonBones::PersonBones(const SceneModel& scene, const GraphOptions& options)
    : options_(options),
      frame_s_(1.0 / scene.frame_rate_hz),
      spreads_(scene.skeleton),
      lengths_(scene.skeleton) {}

void PersonBones::SetLasting(const ErrorCorrelation& lasting) {
  if (options_.pixel_noise_from != NoiseFrom::kRecording) return;
  spreads_.SetLasting(lasting, frame_s_);
}

void PersonBones::AddFrame(const PersonProblem& problem, size_t k) {
  if (options_.bone_sigma_from == NoiseFrom::kRecording) {
    spreads_.AddFrame(
        LocateBoneEnds(problem, k, options_.inlier_weight, frame_s_));
    return;
  }
  for (size_t i = 0; i < spreads_.bones().size(); ++i) {
    const JointChain& a = problem.joints[spreads_.bones()[i].a];
    const JointChain& b = problem.joints[spreads_.bones()[i].b];
    if (CountInliers(a, k, options_.inlier_weight) < 2) continue;
    if (CountInliers(b, k, options_.inlier_weight) < 2) continue;
    lengths_.Add(static_cast<int>(i),
                 (a.states[k].head<3>() - b.states[k].head<3>()).norm(),
                 frame_s_);
  }
}

std::vector<BoneConstraint> PersonBones::Constraints(
    const std::vector<bool>& placed, BoneUse use) const {
  std::vector<BoneConstraint> constraints;
  for (size_t i = 0; i < spreads_.bones().size(); ++i) {
    const int bone_idx = static_cast<int>(i);
    const Bone& bone = spreads_.bones()[i];
    if (!placed[bone.a] || !placed[bone.b]) continue;
    if (options_.bone_sigma_from == NoiseFrom::kFixed) {
      const std::optional<double> length_m = lengths_.Length(bone_idx);
      if (!length_m.has_value()) continue;
      constraints.push_back({bone.a, bone.b, *length_m, options_.bone_sigma_m});
    } else {
      const auto estimate = spreads_.Estimate(bone_idx);
      if (!estimate.has_value() || estimate->gives_way) continue;
      constraints.push_back(ConstraintOf(bone, *estimate, use));
    }
  }
  return constraints;
}

}  // namespace kinegraph
