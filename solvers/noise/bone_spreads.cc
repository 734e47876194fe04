#include "solvers/noise/bone_spreads.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

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

// The value at which `share` of the weight lies below.
double WeightedQuantile(std::vector<std::pair<double, double>> values,
                        double share) {
  std::sort(values.begin(), values.end());
  double total = 0.0;
  for (const auto& [value, weight] : values) total += weight;
  double below = 0.0;
  for (const auto& [value, weight] : values) {
    below += weight;
    if (below >= share * total) return value;
  }
  return values.back().first;
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
  // E |d + e| = |d| + (variance across) / (2 |d|) to second order.
  const double longer = (noise.trace() - look.variance_m2) / (2.0 * distance);
  if (!(longer < 0.5 * distance)) return std::nullopt;
  look.length_m = distance - longer;
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
  summary.known = true;
  const std::vector<BoneLook>& looks = seen.looks;
  std::vector<std::pair<double, double>> values;
  values.reserve(looks.size());

  // How right the modelled noise is.
  for (const BoneLook& look : looks) {
    values.emplace_back(look.square / LowChiSquare(look.freedom), look.freedom);
  }
  const double scale = std::max(1e-6, WeightedQuantile(values, 0.3));
  values.clear();
  for (const BoneLook& look : looks)
    values.emplace_back(look.averaged_frames, 1.0);
  summary.averaged_frames = WeightedQuantile(values, 0.5);

  // Length and spread in turn; they hardly depend on each other.
  double spread = 0.0;   // variance
  double missing = 0.0;  // share of the noise that looks do not show
  for (int round = 0; round < 3; ++round) {
    values.clear();
    for (const BoneLook& look : looks) {
      values.emplace_back(look.length_m,
                          1.0 / (scale * look.variance_m2 + spread + 1e-8));
    }
    summary.length_m = WeightedQuantile(values, 0.5);
    const auto quartile = [&](double variance) {
      values.clear();
      for (const BoneLook& look : looks) {
        const double away = look.length_m - summary.length_m;
        values.emplace_back(
            away * away / (scale * look.variance_m2 + variance + 1e-8), 1.0);
      }
      return WeightedQuantile(values, 0.75);
    };
    double low = 0.0;
    double high = 0.25;  // half a metre, squared
    const double without = quartile(low);
    if (without <= kUpperQuartile) {
      spread = 0.0;
      missing = 1.0 - without / kUpperQuartile;
      continue;
    }
    missing = 0.0;
    constexpr int kHalvings = 30;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (quartile(middle) > kUpperQuartile ? low : high) = middle;
    }
    spread = high;
  }
  // Correlation of neighbouring looks, and what all of them together are
  // worth: information, and the total variance of one look.
  double product = 0.0;
  double square = 0.0;
  double information = 0.0;
  double previous = 0.0;
  for (size_t i = 0; i < looks.size(); ++i) {
    const double variance = scale * looks[i].variance_m2 + spread + 1e-8;
    // Outliers would feign independence.
    const double z =
        std::clamp((looks[i].length_m - summary.length_m) / std::sqrt(variance),
                   -3.0, 3.0);
    if (i > 0) product += z * previous;
    square += z * z;
    information += 1.0 / variance;
    previous = z;
  }
  const auto count = static_cast<double>(looks.size());
  const double rho =
      square > 0.0 ? std::clamp(product / square, 0.0, 0.99) : 0.0;
  const double of_mean = std::max(1.0, count * (1.0 - rho) / (1.0 + rho));
  const double of_square =
      std::max(1.0, count * (1.0 - rho * rho) / (1.0 + rho * rho));
  const double variance = count / information;
  summary.spread_variance_m2 = spread - missing * variance;
  summary.length_variance_m2 = kMedianVariance * variance / of_mean;
  const double share = std::sqrt(kQuartileVariance / of_square);
  summary.spread_error_m2 = variance * share;
  summary.rigid_error_m2 = (variance - spread) * share;
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
                            LossKind loss) {
  BoneConstraint constraint;
  constraint.a = bone.a;
  constraint.b = bone.b;
  constraint.length_m = estimate.length_m;
  const double spread_m2 = Square(estimate.spread_m);
  const double hidden_m2 = Square(estimate.spread_bound_m) - spread_m2;
  const double frames = estimate.averaged_frames;
  constraint.sigma_m =
      std::sqrt(frames * spread_m2 + std::sqrt(frames) * hidden_m2 +
                Square(estimate.length_sigma_m));
  constraint.loss = loss;
  constraint.loss_scale =
      3.0 * std::hypot(estimate.spread_bound_m, estimate.length_sigma_m) /
      constraint.sigma_m;
  return constraint;
}

std::vector<BoneConstraint> ConstraintsOf(const BoneSpreads& spreads,
                                          LossKind loss,
                                          const std::vector<bool>& placed) {
  std::vector<BoneConstraint> constraints;
  for (size_t i = 0; i < spreads.bones().size(); ++i) {
    const Bone& bone = spreads.bones()[i];
    if (!placed[static_cast<size_t>(bone.a)] ||
        !placed[static_cast<size_t>(bone.b)]) {
      continue;
    }
    const auto estimate = spreads.Estimate(static_cast<int>(i));
    if (!estimate.has_value() || estimate->gives_way) continue;
    constraints.push_back(ConstraintOf(bone, *estimate, loss));
  }
  return constraints;
}

}  // namespace kinegraph
