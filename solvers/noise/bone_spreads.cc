#include "solvers/noise/bone_spreads.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/weighted_quantile.h"
#include "solvers/noise/bone_length_fit.h"

namespace kinegraph {
namespace {

// People differ by a tenth, and detectors place joints elsewhere than
// anatomists do.
constexpr double kPopulationShare = 0.15;
// Left from right, of one person and one detector [m].
constexpr double kAsymmetry = 0.01;
// Looks without which a bone that no population knows is not known.
constexpr int64_t kEnough = 25;
// A length that varies by more than this share of itself says nothing that the
// motion does not say better.
constexpr double kGivesWay = 0.2;

// Variance of the logarithm of a scale found from the upper quartile of N
// values of chi-square with one degree of freedom, times N: p (1 - p) / (x
// f(x))^2 with p = 0.75, x = 1.3233, f the density.
constexpr double kQuartileVariance = 3.34;
// Of a median of N Gaussian values, times N, over that of a mean.
constexpr double kMedianVariance = 1.571;

bool SameBone(const Bone& x, int a, int b) {
  return (x.a == a && x.b == b) || (x.a == b && x.b == a);
}

double UsualAveragedFrames(const std::vector<BoneObservation>& looks) {
  std::vector<WeightedValue> values;
  values.reserve(looks.size());
  for (const BoneObservation& look : looks) {
    values.emplace_back(look.averaged_frames, 1.0);
  }
  return WeightedQuantile(std::move(values), 0.5);
}

// How many independent looks these are worth, for a mean and for a variance:
// neighbours are alike.
struct Worth {
  double of_mean = 1.0;
  double of_square = 1.0;
};

Worth WorthOf(const std::vector<double>& deviations) {
  double product = 0.0;
  double square = 0.0;
  double previous = 0.0;
  for (const double deviation : deviations) {
    // Outliers would feign independence.
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

// Variance of the mean of errors whose correlation is exp(-|dt| / tau) over a
// time T, over that of one of them; x = T / tau.
double MeanOfLasting(double x) {
  constexpr double kShort = 1e-3;
  if (x < kShort) return 1.0;
  return 2.0 / x - 2.0 * (1.0 - std::exp(-x)) / (x * x);
}

}  // namespace

BoneSpreads::BoneSpreads(const Skeleton& skeleton)
    : bones_(RigidPairs(skeleton)),
      mirror_(bones_.size(), -1),
      seen_(bones_.size()),
      summaries_(bones_.size()) {
  for (size_t i = 0; i < bones_.size(); ++i) {
    const int mirror_a = skeleton.mirror(bones_[i].a);
    const int mirror_b = skeleton.mirror(bones_[i].b);
    for (size_t other = 0; other < bones_.size(); ++other) {
      if (other != i && SameBone(bones_[other], mirror_a, mirror_b)) {
        mirror_[i] = static_cast<int>(other);
      }
    }
    population_m_.push_back(PopulationLength(skeleton.joints()[bones_[i].a],
                                             skeleton.joints()[bones_[i].b]));
  }
}

void BoneSpreads::Add(int bone_idx, const BoneObservation& look) {
  Seen& seen = seen_[static_cast<size_t>(bone_idx)];
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
  const Seen& seen = seen_[static_cast<size_t>(bone_idx)];
  Summary& summary = summaries_[static_cast<size_t>(bone_idx)];
  if (seen.looks.empty() || 10 * seen.count < 11 * summary.at_count) {
    return summary;
  }
  summary.at_count = seen.count;
  summary.averaged_frames = UsualAveragedFrames(seen.looks);
  const LengthFit fit = FitLength(seen.looks);
  summary.known = fit.known;
  if (!fit.known) return summary;
  const Worth worth = WorthOf(fit.deviations);
  double information = 0.0;
  for (const double variance : fit.variances_m2) information += 1.0 / variance;
  const auto count = static_cast<double>(seen.looks.size());
  const double variance = count / information;
  const double share = std::sqrt(kQuartileVariance / worth.of_square);
  summary.length_m = fit.length_m;
  summary.length_variance_m2 =
      (fit.is_median ? kMedianVariance : 1.0) * variance / worth.of_mean;
  summary.noise_m2 = fit.noise_m2;
  summary.spread_variance_m2 = fit.spread_m2;
  summary.spread_error_m2 = variance * share;
  summary.rigid_error_m2 = fit.noise_m2 * share;
  return summary;
}

// Deviations show how long errors last up to a good part of the recording; what
// stays for longer moves all looks alike.
double BoneSpreads::LengthVariance(const Summary& summary) const {
  if (!(lasting_.share > 0.0)) return summary.length_variance_m2;
  const double seen_s = static_cast<double>(summary.at_count) * frame_s_;
  return std::max(summary.length_variance_m2,
                  summary.noise_m2 * lasting_.share *
                      MeanOfLasting(seen_s / lasting_.time_s));
}

BoneSpreads::Pool BoneSpreads::PooledSpread() const {
  double weights = 0.0;
  double squares = 0.0;  // of weights
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
  BoneEstimate estimate;
  estimate.looks = seen_[at].count;
  const bool enough =
      estimate.looks + (mirror == nullptr
                            ? 0
                            : seen_[static_cast<size_t>(mirror_[at])].count) >=
      kEnough;
  if (!population_m.has_value() && !enough) return std::nullopt;
  if (!(information > 0.0)) return std::nullopt;  // shorter than any noise
  estimate.length_m = sum / information;
  estimate.length_sigma_m = std::sqrt(1.0 / information);
  // What was seen of neither side may vary as the population does.
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

std::vector<BoneConstraint> ConstraintsOf(const BoneSpreads& spreads,
                                          const std::vector<bool>& placed,
                                          BoneUse use) {
  std::vector<BoneConstraint> constraints;
  for (size_t i = 0; i < spreads.bones().size(); ++i) {
    const Bone& bone = spreads.bones()[i];
    if (!placed[static_cast<size_t>(bone.a)] ||
        !placed[static_cast<size_t>(bone.b)]) {
      continue;
    }
    const auto estimate = spreads.Estimate(static_cast<int>(i));
    if (!estimate.has_value() || estimate->gives_way) continue;
    constraints.push_back(ConstraintOf(bone, *estimate, use));
  }
  return constraints;
}

}  // namespace kinegraph
