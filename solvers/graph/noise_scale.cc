#include "solvers/graph/noise_scale.h"

#include <algorithm>
#include <cmath>

#include "solvers/graph/factor_list.h"

namespace kinegraph {

namespace {

// trace(J C J') of the residuals of one state with covariance C.
template <typename Jacobian>
double ExplainedVariance(const Jacobian& by_state, const Matrix6d& covariance) {
  Eigen::Matrix<double, Jacobian::kRows, kStateSize> J;
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
      // A view that alone decides where the joint is tells nothing of noise.
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
  // As if this many residuals of scale 1 had been seen before.
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
  constexpr size_t kCapacity = 4000;  // a minute at 17 joints, 4 views, 25 Hz
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
