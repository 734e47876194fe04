#include "solvers/noise/motion_lag.h"

#include <Eigen/LU>
#include <algorithm>

namespace kinegraph {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector3d;

// Kalman's filter and the smoother of Rauch, Tung and Striebel for positions
// that white noise on acceleration drives. The axes share their variances.
class MotionSmoother {
 public:
  explicit MotionSmoother(const std::vector<LagSample>& samples)
      : steps_(samples.size()) {
    constexpr double kUnknown = 1e4;  // m^2 and (m/s)^2
    Matrix2d covariance = kUnknown * Matrix2d::Identity();
    for (size_t k = 0; k < steps_.size(); ++k) {
      const LagSample& sample = samples[k];
      Step& step = steps_[k];
      if (k > 0) {
        const double dt = sample.time_s - samples[k - 1].time_s;
        Matrix2d drive;
        drive << dt * dt / 3.0, dt / 2.0, dt / 2.0, 1.0;
        step.transition(0, 1) = dt;
        const Matrix2d filtered = covariance;
        covariance = step.transition * filtered * step.transition.transpose() +
                     sample.process_noise * dt * drive;
        steps_[k - 1].back =
            filtered * step.transition.transpose() * covariance.inverse();
      }
      if (!sample.point_m.allFinite()) continue;
      const double variance_m2 = sample.variance_m2 * sample.expected.divisor;
      step.gain = covariance.col(0) / (covariance(0, 0) + variance_m2);
      covariance -= step.gain * covariance.row(0).eval();
    }
  }

  // In place. NaN: none.
  void Smooth(std::vector<Vector3d>* values) const {
    using Motion = Eigen::Matrix<double, 2, 3>;  // position, velocity
    std::vector<Motion> predicted, filtered;
    Motion motion = Motion::Zero();
    for (size_t k = 0; k < steps_.size(); ++k) {
      motion = steps_[k].transition * motion;
      predicted.push_back(motion);
      const Vector3d& value = (*values)[k];
      if (value.allFinite()) {
        motion += steps_[k].gain * (value.transpose() - motion.row(0)).eval();
      }
      filtered.push_back(motion);
    }
    for (size_t k = steps_.size(); k-- > 0;) {
      if (k + 1 < steps_.size()) {
        motion =
            filtered[k] + steps_[k].back * (motion - predicted[k + 1]).eval();
      }
      (*values)[k] = motion.row(0).transpose();
    }
  }

 private:
  struct Step {
    Matrix2d transition = Matrix2d::Identity();  // from the step before
    Eigen::Vector2d gain = Eigen::Vector2d::Zero();
    Matrix2d back = Matrix2d::Zero();
  };
  std::vector<Step> steps_;
};

}  // namespace

void LagLearner::Add(const std::vector<LagSample>& samples) {
  const MotionSmoother smoother(samples);
  std::vector<Vector3d> left;
  for (const LagSample& sample : samples) left.push_back(sample.point_m);
  smoother.Smooth(&left);
  for (size_t k = 0; k < left.size(); ++k) {
    left[k] = samples[k].point_m - left[k];
  }
  const std::vector<Vector3d> first = left;
  smoother.Smooth(&left);
  // What is expected holds away from the ends.
  constexpr double kEndsS = 0.2;
  for (size_t k = 0; k < left.size(); ++k) {
    const LagSample& sample = samples[k];
    if (!sample.point_m.allFinite() ||
        sample.time_s < samples.front().time_s + kEndsS ||
        sample.time_s > samples.back().time_s - kEndsS) {
      continue;
    }
    const Leftover& expected = sample.expected;
    const double weight = expected.independent;
    count_ += weight;
    first_.push_back(
        static_cast<float>(first[k].squaredNorm() / expected.first_noise_m2));
    first_lag_ += weight * expected.first_lag_m2 / expected.first_noise_m2;
    left_ += weight * left[k].squaredNorm() / 3.0 / expected.lag_m2;
    left_noise_ += weight * expected.noise_m2 / expected.lag_m2;
  }
}

LagLearner::Ratios LagLearner::Fit() const {
  // As if so many values had been as expected before.
  constexpr double kPrior = 30.0;
  // Above one it is outliers, or errors that last otherwise than was learnt,
  // which tell nothing below the crossover.
  constexpr double kLeastNoise = 0.5;
  constexpr double kMostNoise = 1.0;
  constexpr double kMostLag = 4.0;
  // Of the squared norm of three normal values. Outliers do not move a median.
  constexpr double kMedian = 2.366;
  if (first_.empty()) return {};
  std::vector<float> ascending = first_;
  const auto middle = ascending.begin() + ascending.size() / 2;
  std::nth_element(ascending.begin(), middle, ascending.end());
  const double first = count_ * *middle / kMedian + kPrior;
  const double left = left_ + kPrior;
  // first = noise count + lag first_lag_, left = noise left_noise_ + lag count,
  // each with the prior's values on both sides.
  const double count = count_ + kPrior;
  const double noise =
      std::clamp((first * count - left * first_lag_) /
                     (count * count - first_lag_ * left_noise_),
                 kLeastNoise, kMostNoise);
  return {noise,
          std::clamp((left - noise * left_noise_) / count, 0.0, kMostLag)};
}

}  // namespace kinegraph
