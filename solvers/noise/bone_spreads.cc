#include "solvers/noise/bone_spreads.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/weighted_quantile.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

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

// Of chi-square with one degree of freedom.
constexpr double kUpperQuartile = 1.3233;
// Variance of the logarithm of a scale found from that quantile of N values,
// times N: p (1 - p) / (x f(x))^2 with p = 0.75, x = 1.3233, f the density.
constexpr double kQuartileVariance = 3.34;
// Of a median of N Gaussian values, times N, over that of a mean.
constexpr double kMedianVariance = 1.571;

double Square(double x) { return x * x; }

bool SameBone(const Bone& x, int a, int b) {
  return (x.a == a && x.b == b) || (x.a == b && x.b == a);
}

// Quantile 0.3 of chi-square (Wilson and Hilferty 1931): within 1 % from one
// degree of freedom on.
double LowChiSquare(int freedom) {
  constexpr double kNormal = -0.5244;  // of the standard normal at 0.3
  const double spread = 2.0 / (9.0 * freedom);
  const double root = 1.0 - spread + kNormal * std::sqrt(spread);
  return freedom * root * root * root;
}

// Normal equations of the views that count.
struct NormalEquations {
  Matrix3d information = Matrix3d::Zero();
  Matrix3d solver_information = Matrix3d::Zero();  // as the solver weighs them
  Vector3d gradient = Vector3d::Zero();
  double square = 0.0;
  int views = 0;
};

NormalEquations Linearise(const JointChain& chain, size_t k,
                          double inlier_weight, const Vector3d& at) {
  NormalEquations sum;
  for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
    const PixelMeasurement& measurement = chain.measurements[m];
    if (measurement.gated || measurement.weight < inlier_weight) continue;
    Matrix23d jacobian;
    const auto image = measurement.camera->Project(at, &jacobian);
    if (!image.has_value()) continue;
    const double sigma = measurement.sigma_px;
    const Eigen::Vector2d residual =
        (*image + measurement.bias_px.cast<double>() - measurement.px) / sigma;
    const Matrix23d whitened = jacobian / sigma;
    const Matrix3d square = whitened.transpose() * whitened;
    sum.information += square;
    sum.solver_information +=
        measurement.weight * measurement.information * square;
    sum.gradient += whitened.transpose() * residual;
    sum.square += residual.squaredNorm();
    ++sum.views;
  }
  return sum;
}

// Noise-equivalent length of the smoother that is optimal for white noise on
// acceleration, H(w) = 1 / (1 + (w / w_c)^4) with w_c^4 = q / (R h): it
// averages over pi / (0.833 w_c) seconds (0.833: the integral of H^2 over w /
// w_c). Not more than a second: motion is not stationary for longer.
double AveragedFrames(const JointChain& chain, size_t k, double variance_m2,
                      double interval_s) {
  if (chain.process_noise.empty()) return 1.0;
  const double noise =
      chain.process_noise[std::min(k, chain.process_noise.size() - 1)];
  const double crossover = std::pow(noise / (variance_m2 * interval_s), 0.25);
  const double seconds = std::min(1.0, 3.77 / crossover);
  return std::max(1.0, seconds / interval_s);
}

std::optional<BoneEnd> LocateEnd(const JointChain& chain, size_t k,
                                 double inlier_weight, double interval_s) {
  // Gauss-Newton from the estimate, which is near.
  constexpr int kSteps = 3;
  BoneEnd end;
  end.position_m = chain.states[k].head<3>();
  NormalEquations sum;
  for (int step = 0; step < kSteps; ++step) {
    sum = Linearise(chain, k, inlier_weight, end.position_m);
    if (sum.views < 2) return std::nullopt;
    const Eigen::LDLT<Matrix3d> factor(sum.information);
    // A direction that is open to ten metres is no position.
    constexpr double kOpen = 0.01;  // 1 / m^2
    if (!factor.isPositive() || !(factor.vectorD().minCoeff() > kOpen)) {
      return std::nullopt;
    }
    end.position_m -= factor.solve(sum.gradient);
  }
  if (!end.position_m.allFinite()) return std::nullopt;
  end.covariance_m2 = sum.information.ldlt().solve(Matrix3d::Identity());
  end.square = sum.square;
  end.freedom = 2 * sum.views - 3;
  const Matrix3d of_solver =
      sum.solver_information.ldlt().solve(Matrix3d::Identity());
  end.averaged_frames =
      AveragedFrames(chain, k, of_solver.trace() / 3.0, interval_s);
  return end;
}

// What looks say of a length, and how each of them deviates from it.
struct LengthFit {
  bool known = false;
  double length_m = 0.0;
  // Below zero where looks vary less than their noise says.
  double spread_m2 = 0.0;
  double noise_m2 = 0.0;             // of a look's length, on average
  std::vector<double> deviations;    // of the looks, in sigmas
  std::vector<double> variances_m2;  // of their lengths, spread included
};

// How right the modelled noise is: factor on its variance.
double NoiseScale(const std::vector<BoneLook>& looks) {
  std::vector<WeightedValue> values;
  values.reserve(looks.size());
  for (const BoneLook& look : looks) {
    values.emplace_back(look.square / LowChiSquare(look.freedom), look.freedom);
  }
  return std::max(1e-6, WeightedQuantile(std::move(values), 0.3));
}

double UsualAveragedFrames(const std::vector<BoneLook>& looks) {
  std::vector<WeightedValue> values;
  values.reserve(looks.size());
  for (const BoneLook& look : looks) {
    values.emplace_back(look.averaged_frames, 1.0);
  }
  return WeightedQuantile(std::move(values), 0.5);
}

double Length(const BoneLook& look, double scale) {
  return look.distance_m - scale * look.added_m;
}

// What keeps the variance of exact looks above zero [m^2].
constexpr double kLeastVariance = 1e-8;

// Upper quartile of the looks' squared deviations, were the spread's variance
// `spread`.
double UpperQuartile(const std::vector<BoneLook>& looks, double scale,
                     double length_m, double spread) {
  std::vector<WeightedValue> values;
  values.reserve(looks.size());
  for (const BoneLook& look : looks) {
    values.emplace_back(
        Square(Length(look, scale) - length_m) /
            (scale * look.variance_m2 + spread + kLeastVariance),
        1.0);
  }
  return WeightedQuantile(std::move(values), 0.75);
}

// Of a bone that is much longer than the noise: length and spread in turn,
// which hardly depend on each other.
LengthFit FitLength(const std::vector<BoneLook>& looks, double scale) {
  LengthFit fit;
  fit.known = true;
  double spread = 0.0;   // variance
  double missing = 0.0;  // share of the noise that looks do not show
  for (int round = 0; round < 3; ++round) {
    std::vector<WeightedValue> values;
    values.reserve(looks.size());
    for (const BoneLook& look : looks) {
      values.emplace_back(Length(look, scale), 1.0 / (scale * look.variance_m2 +
                                                      spread + kLeastVariance));
    }
    fit.length_m = WeightedQuantile(std::move(values), 0.5);
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
  for (const BoneLook& look : looks) {
    const double variance = scale * look.variance_m2 + spread + kLeastVariance;
    fit.variances_m2.push_back(variance);
    fit.deviations.push_back((Length(look, scale) - fit.length_m) /
                             std::sqrt(variance));
    information += 1.0 / variance;
  }
  const double variance = static_cast<double>(looks.size()) / information;
  fit.noise_m2 = variance - spread;
  fit.spread_m2 = spread - missing * variance;
  return fit;
}

// Of a bone beside which the noise is not small. A look's |d|^2 - tr N has the
// variance 4 L^2 v + 2 tr N^2 around L^2, with v along the bone.
LengthFit FitSquaredLength(const std::vector<BoneLook>& looks, double scale) {
  constexpr double kFar = 4.0;  // sigmas
  std::vector<WeightedValue> values;
  values.reserve(looks.size());
  for (const BoneLook& look : looks) {
    values.emplace_back(Square(look.distance_m) - scale * look.noise_m2, 1.0);
  }
  // From the median, which lies below the mean; a mean it has to be.
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
  fit.length_m = std::sqrt(std::max(0.0, square_m2));
  if (!(fit.length_m > 0.0)) return fit;
  fit.known = true;
  double information = 0.0;
  for (size_t i = 0; i < looks.size(); ++i) {
    fit.variances_m2.push_back(variances_m4[i] / (4.0 * square_m2));
    fit.deviations.push_back((values[i].first - square_m2) /
                             std::sqrt(variances_m4[i]));
    information += 1.0 / fit.variances_m2.back();
  }
  fit.noise_m2 = static_cast<double>(looks.size()) / information;
  return fit;
}

// Whether the noise across the bone lengthens it by more than a twentieth: from
// there on the second order is not enough.
bool IsNoisy(const std::vector<BoneLook>& looks, double scale) {
  constexpr double kMost = 0.1;  // tr N / L^2
  std::vector<WeightedValue> squares;
  std::vector<WeightedValue> noises;
  for (const BoneLook& look : looks) {
    squares.emplace_back(Square(look.distance_m), 1.0);
    noises.emplace_back(scale * look.noise_m2, 1.0);
  }
  const double noise = WeightedQuantile(std::move(noises), 0.5);
  const double square = WeightedQuantile(std::move(squares), 0.5);
  return noise > kMost * (square - noise);
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

}  // namespace

std::vector<std::optional<BoneEnd>> LocateBoneEnds(const PersonProblem& problem,
                                                   size_t frame_idx,
                                                   double inlier_weight,
                                                   double interval_s) {
  std::vector<std::optional<BoneEnd>> ends;
  ends.reserve(problem.joints.size());
  for (const JointChain& chain : problem.joints) {
    ends.push_back(LocateEnd(chain, frame_idx, inlier_weight, interval_s));
  }
  return ends;
}

std::optional<BoneLook> LookAtBone(const BoneEnd& a, const BoneEnd& b) {
  const Vector3d between = a.position_m - b.position_m;
  const double distance = between.norm();
  if (!(distance > 0.0)) return std::nullopt;
  const Matrix3d noise = a.covariance_m2 + b.covariance_m2;
  const Vector3d along = between / distance;
  BoneLook look;
  look.variance_m2 = along.dot(noise * along);
  look.distance_m = distance;
  look.noise_m2 = noise.trace();
  look.noise_square_m4 = noise.squaredNorm();
  // E |d + e| = |d| + (variance across) / (2 |d|) to second order.
  look.added_m = (look.noise_m2 - look.variance_m2) / (2.0 * distance);
  look.square = a.square + b.square;
  look.freedom = a.freedom + b.freedom;
  look.averaged_frames = std::max(a.averaged_frames, b.averaged_frames);
  return look;
}

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

void BoneSpreads::Add(int bone_idx, const BoneLook& look) {
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
  const double scale = NoiseScale(seen.looks);
  const bool noisy = IsNoisy(seen.looks, scale);
  const LengthFit fit = noisy ? FitSquaredLength(seen.looks, scale)
                              : FitLength(seen.looks, scale);
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
      (noisy ? 1.0 : kMedianVariance) * variance / worth.of_mean;
  summary.spread_variance_m2 = fit.spread_m2;
  summary.spread_error_m2 = variance * share;
  summary.rigid_error_m2 = fit.noise_m2 * share;
  return summary;
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
  if (own.known) add(own.length_m, own.length_variance_m2);
  if (mirror != nullptr) {
    add(mirror->length_m, mirror->length_variance_m2 + kAsymmetry * kAsymmetry);
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
                            LossKind loss, BoneUse use) {
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
  constraint.loss = loss;
  constraint.loss_scale =
      3.0 * std::hypot(estimate.spread_bound_m, estimate.length_sigma_m) /
      constraint.sigma_m;
  return constraint;
}

std::vector<BoneConstraint> ConstraintsOf(const BoneSpreads& spreads,
                                          LossKind loss,
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
    constraints.push_back(ConstraintOf(bone, *estimate, loss, use));
  }
  return constraints;
}

}  // namespace kinegraph
