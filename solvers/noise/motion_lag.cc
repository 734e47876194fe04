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
    const double variance_m2 = left[k].squaredNorm() / 3.0;
    excess_ += expected.independent * (variance_m2 - expected.noise_m2) /
               expected.lag_m2;
    count_ += expected.independent;
  }
}

double LagLearner::Lag() const {
  // As if so many values had agreed with the prior before.
  constexpr double kPrior = 30.0;
  constexpr double kMost = 4.0;
  return std::clamp((excess_ + kPrior) / (count_ + kPrior), 0.0, kMost);
}

}  // namespace kinegraph
