#include "solvers/noise/pixel_noise.h"

#include <algorithm>
#include <cmath>

#include "core/base/weighted_quantile.h"
#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

// The regularised incomplete gamma function P(a, x) by its series (Abramowitz
// and Stegun 6.5.29). It converges for every x; the requested quantiles are
// near a.
double GammaShare(double a, double x) {
  if (x <= 0.0) return 0.0;
  double term = 1.0 / a;
  double sum = term;
  for (double n = a + 1.0; term > 1e-17 * sum; n += 1.0) {
    term *= x / n;
    sum += term;
  }
  return sum * std::exp(a * std::log(x) - x - std::lgamma(a));
}

}  // namespace

double ChiSquareQuantile(double share, double degrees_of_freedom) {
  const double a = 0.5 * degrees_of_freedom;
  double low = 0.0;
  double high = a + 1.0;
  while (GammaShare(a, high) < share) high *= 2.0;
  // Sixty halvings reach the precision of a double.
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (GammaShare(a, middle) < share ? low : high) = middle;
  }
  return low + high;  // twice the middle: chi-square is twice gamma
}

namespace {

constexpr double kLowShare = 0.3;

// Quantiles of the sum of squared residuals of a least-squares point, by number
// of views.
class QuantileTable {
 public:
  explicit QuantileTable(double share) {
    for (int views = 2; views <= kMostViews; ++views) {
      quantiles_[views] = ChiSquareQuantile(share, 2.0 * views - 3.0);
    }
  }
  double operator()(size_t views) const {
    return quantiles_[std::min<size_t>(views, kMostViews)];
  }

 private:
  static constexpr int kMostViews = 64;  // larger numbers use the last entry
  std::array<double, kMostViews + 1> quantiles_{};
};

}  // namespace

NoiseScales::NoiseScales() {
  for (Counts& counts : classes_) counts.weight.assign(kBinCount, 0.0f);
  all_.weight.assign(kBinCount, 0.0f);
}

void NoiseScales::Add(JointClass joint_class,
                      const TriangulationResiduals& residuals) {
  static const QuantileTable low(kLowShare);
  const double variance = residuals.square / low(residuals.views.size());
  if (!std::isfinite(variance)) return;
  const double position =
      (std::log(std::max(variance, 1e-300)) - kLeast) / kBin;
  const int bin = static_cast<int>(std::clamp(position, 0.0, kBinCount - 1.0));
  const auto weight = static_cast<float>(residuals.degrees_of_freedom());
  for (Counts* counts : {&classes_[static_cast<int>(joint_class)], &all_}) {
    counts->weight[bin] += weight;
    counts->total += weight;
    ++counts->joints;
  }
}

double NoiseScales::LowQuantile(const Counts& counts) {
  return kLeast + BinnedQuantile(counts.weight, counts.total, kLowShare) * kBin;
}

double NoiseScales::Scale(JointClass joint_class) const {
  // Prior: as if kPrior joints with the modelled sigma had been seen by four
  // views, and kClassPrior of each class with the person's own scale. Fewer
  // views weigh less.
  constexpr double kPrior = 20.0;
  constexpr double kClassPrior = 40.0;
  if (all_.joints == 0) return 1.0;
  constexpr double kFourViews = 5.0;  // degrees of freedom
  const double all_count = all_.total / kFourViews;
  const double all =
      all_count * LowQuantile(all_) / (all_count + kPrior);  // prior: ln 1 = 0
  const Counts& own = classes_[static_cast<int>(joint_class)];
  double log_variance = all;
  if (own.joints > 0) {
    const double count = own.total / kFourViews;
    log_variance =
        (count * LowQuantile(own) + kClassPrior * all) / (count + kClassPrior);
  }
  // The factor is limited, because it would vanish for exact data.
  constexpr double kMost = 16.0;
  return std::clamp(std::exp(0.5 * log_variance), 1.0 / kMost, kMost);
}

int64_t NoiseScales::count(JointClass joint_class) const {
  return classes_[static_cast<int>(joint_class)].joints;
}

CorrelationLearner::CorrelationLearner(int joint_count, int view_count,
                                       double frame_rate_hz)
    : view_count_(view_count),
      frame_s_(1.0 / frame_rate_hz),
      pasts_(static_cast<size_t>(joint_count * view_count)) {
  constexpr double kLongest_s = 0.25;
  constexpr int kLeastLags = 3;
  lags_.resize(static_cast<size_t>(
      std::max<double>(kLeastLags, std::floor(kLongest_s * frame_rate_hz))));
}

void CorrelationLearner::Add(int joint_idx, TimeNs time, double scale,
                             const TriangulationResiduals& residuals) {
  constexpr double kFar = 5.0;  // sigmas
  static const QuantileTable high(0.95);
  if (!(residuals.square < scale * scale * high(residuals.views.size()))) {
    return;
  }
  const int count = static_cast<int>(residuals.views.size());
  const auto longest = static_cast<int64_t>(lags_.size());
  for (const TriangulationResiduals::View& view : residuals.views) {
    const Eigen::Vector2d residual = view.residual / scale;
    if (residual.squaredNorm() > kFar * kFar) continue;
    std::vector<Past>& pasts =
        pasts_[static_cast<size_t>(joint_idx * view_count_ + view.view_idx)];
    const auto lag_of = [&](const Past& past) {
      return std::llround(ToSeconds(time - past.time) / frame_s_);
    };
    pasts.erase(pasts.begin(),
                std::find_if(pasts.begin(), pasts.end(), [&](const Past& past) {
                  return lag_of(past) <= longest;
                }));
    for (const Past& past : pasts) {
      const int64_t lag = lag_of(past);
      if (past.view_count != count || lag < 1) continue;
      Lag& sums = lags_[static_cast<size_t>(lag - 1)];
      sums.product += residual.dot(past.residual);
      sums.square +=
          0.5 * (residual.squaredNorm() + past.residual.squaredNorm());
    }
    pasts.push_back({time, count, residual});
  }
}

ErrorCorrelation CorrelationLearner::Fit() const {
  // Prior typical of detectors (correlation 0.6 to 0.8 at a lag of one frame at
  // 25 Hz), with the weight of this many squared sigmas at each lag.
  constexpr double kPrior = 60.0;
  constexpr double kPriorShare = 0.9;
  constexpr double kPriorTime_s = 0.1;
  // Candidate correlation times in logarithmic steps: sixty from the shortest
  // to a second and 35 more to ten seconds. More persistent errors count as
  // constant offsets.
  constexpr double kShortest_s = 0.02;
  constexpr double kOneSecond = 1.0;
  constexpr int kSteps = 60;
  constexpr int kStepsToLongest = 95;
  // Minimum share of correlated errors, at kItsRateHz; below it the noise is
  // treated as white. White errors average out over frames and correlated
  // errors do not, so at twice the frame rate half the share has the same
  // effect.
  constexpr double kLeastShare = 0.15;
  constexpr double kItsRateHz = 30.0;
  const double least_share = kLeastShare * std::min(1.0, frame_s_ * kItsRateHz);
  struct Seen {
    double weight;
    double correlation;
  };
  std::vector<Seen> seen;
  double total = 0.0;
  for (size_t l = 0; l < lags_.size(); ++l) {
    const double dt_s = static_cast<double>(l + 1) * frame_s_;
    const double weight = lags_[l].square + kPrior;
    const double prior = kPriorShare * std::exp(-dt_s / kPriorTime_s) * kPrior;
    const double correlation = (lags_[l].product + prior) / weight;
    total += weight * correlation * correlation;
    seen.push_back({weight, correlation});
  }
  ErrorCorrelation best;
  best.share = 0.0;
  double least = 1e300;
  for (int i = 0; i <= kStepsToLongest; ++i) {
    const double time_s =
        kShortest_s *
        std::pow(kOneSecond / kShortest_s, static_cast<double>(i) / kSteps);
    const double of_a_frame = std::exp(-frame_s_ / time_s);
    double model = 1.0;
    double cross = 0.0;
    double square = 0.0;
    for (const Seen& lag : seen) {
      model *= of_a_frame;
      cross += lag.weight * model * lag.correlation;
      square += lag.weight * model * model;
    }
    const double share = std::clamp(cross / square, 0.0, 1.0);
    const double misfit = total - 2.0 * share * cross + share * share * square;
    if (misfit < least) {
      least = misfit;
      best = {share, time_s};
    }
  }
  if (best.share < least_share) best.share = 0.0;
  return best;
}

namespace {

// trace(J C J') of the residuals of one state with covariance C.
double ExplainedVariance(const CameraReprojection::Jacobian& by_state,
                         const Matrix6d& covariance) {
  Eigen::Matrix<double, CameraReprojection::kResiduals, kStateSize> J;
  for (int row = 0; row < J.rows(); ++row) {
    for (int i = 0; i < kStateSize; ++i) J(row, i) = by_state(row, i);
  }
  return (J * covariance).cwiseProduct(J).sum();
}

}  // namespace

void CollectSquares(const JointChain& chain,
                    const std::vector<Matrix6d>& covariances, size_t begin,
                    size_t end, std::vector<double>* squares) {
  for (size_t k = begin; k < end; ++k) {
    const double* states[] = {chain.states[k].data()};
    for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
      const PixelMeasurement& measurement = chain.measurements[m];
      if (measurement.gated) continue;
      Linearised<CameraReprojection> at;
      if (!ReprojectionOf(measurement)
               .Evaluate(states, at.residual, at.by_states)) {
        continue;
      }
      // A view that alone determines the joint carries no information about
      // noise.
      const double left =
          1.0 - 0.5 * ExplainedVariance(at.by_states[0], covariances[k]);
      if (left < 0.3) continue;
      squares->push_back(at.squared_norm() / left);
    }
  }
}

double EstimateNoiseScale(std::vector<double> squares) {
  if (squares.empty()) return 1.0;
  // |r|^2 of a standard normal 2-vector is exponential with mean 2.
  const double kMedian = 2.0 * std::log(2.0);
  constexpr double kGate = 9.0;
  const double tail = std::exp(-0.5 * kGate);
  const double mean_within = 2.0 - kGate * tail / (1.0 - tail);
  const auto middle = squares.begin() + squares.size() / 2;
  std::nth_element(squares.begin(), middle, squares.end());
  double variance = *middle / kMedian;
  for (int iteration = 0; iteration < 10; ++iteration) {
    double sum = 0.0;
    double count = 0.0;
    for (const double s : squares) {
      if (s > kGate * variance) continue;
      sum += s;
      count += 1.0;
    }
    if (count == 0.0) break;
    variance = sum / count / mean_within;
  }
  // The prior counts as this many residuals of scale 1.
  constexpr double kPriorCount = 20.0;
  const double count = static_cast<double>(squares.size());
  variance = (count * variance + kPriorCount) / (count + kPriorCount);
  return std::clamp(std::sqrt(variance), 0.25, 4.0);
}

void ScaleSigmas(double scale, PersonProblem* problem) {
  for (JointChain& chain : problem->joints) {
    for (PixelMeasurement& measurement : chain.measurements) {
      measurement.sigma_px *= scale;
    }
  }
}

bool CausalNoiseScale::AwaitTurn() {
  constexpr int64_t kStride = 5;
  return turns_++ % kStride == 0;
}

void CausalNoiseScale::Add(const std::vector<double>& squares, double applied) {
  // 12 s for 17 joints, 4 views and 25 Hz, with one frame in five (AwaitTurn).
  constexpr size_t kCapacity = 4000;
  for (const double square : squares) {
    const double unscaled = square * applied * applied;
    if (squares_.size() < kCapacity) {
      squares_.push_back(unscaled);
    } else {
      squares_[next_] = unscaled;
      next_ = (next_ + 1) % kCapacity;
    }
  }
  scale_ = EstimateNoiseScale(squares_);
}

}  // namespace kinegraph
