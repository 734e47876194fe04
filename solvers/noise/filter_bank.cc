#include "solvers/noise/filter_bank.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

constexpr double kLeastLevel = 1.0 / 40.0;
constexpr double kGreatestLevel = 1000.0;

}  // namespace

double UsualProcessNoise(JointClass joint_class) {
  // head trunk shoulder elbow wrist hip knee ankle foot other
  constexpr std::array<double, kJointClassCount> kUsual = {
      0.6, 0.6, 0.6, 1.3, 3.8, 0.65, 3.5, 8.4, 8.4, 3.8};
  return kUsual[static_cast<int>(joint_class)];
}

double LogLevelStep() {
  return std::log(kGreatestLevel / kLeastLevel) / (kLevelCount - 1);
}

double LogLevel(int level) {
  return std::log(kLeastLevel) + level * LogLevelStep();
}

void FilterBank::Add(TimeNs time, const std::optional<FramePoint>& point,
                     const ErrorCorrelation& correlation, Levels* evidence) {
  if (!started_) {
    if (!point.has_value()) return;
    started_ = true;
    time_ = time;
    for (Filter& filter : filters_) {
      for (int i = 0; i < 3; ++i) filter.axes[i].p = point->position_m[i];
    }
  }
  constexpr double kKnown = 3.0;  // of the mean of e^2 / S
  const double dt = ToSeconds(time - time_);
  time_ = time;
  const double phi = std::exp(-dt / correlation.time_s);
  for (int level = 0; level < kLevelCount; ++level) {
    Filter& filter = filters_[level];
    const double q = usual_ * std::exp(LogLevel(level));
    for (Axis& x : filter.axes) {
      x.p += dt * x.v;
      x.n *= phi;
      x.pp += dt * (2.0 * x.pv + dt * x.vv) + q * dt * dt * dt / 3.0;
      x.pv += dt * x.vv + 0.5 * q * dt * dt;
      x.vv += q * dt;
      x.pn = phi * (x.pn + dt * x.vn);
      x.vn *= phi;
      x.nn = phi * phi * x.nn + 1.0 - phi * phi;
    }
    if (!point.has_value()) continue;
    std::array<double, 3> gain{};  // of the lasting error
    std::array<double, 3> error{};
    std::array<double, 3> spread{};
    double mean = 0.0;
    double log_spread = 0.0;
    for (int i = 0; i < 3; ++i) {
      const Axis& x = filter.axes[i];
      const double variance = point->covariance_m2(i, i);
      gain[i] = std::sqrt(correlation.share * variance);
      error[i] = point->position_m[i] - x.p - gain[i] * x.n;
      spread[i] = x.pp + 2.0 * gain[i] * x.pn + gain[i] * gain[i] * x.nn +
                  (1.02 - correlation.share) * variance + 1e-8;
      mean += error[i] * error[i] / spread[i] / 3.0;
      log_spread += std::log(spread[i]);
    }
    const double robust =
        mean <= kKnown ? mean : kKnown * (1.0 + std::log(mean / kKnown));
    (*evidence)[level] -= 0.5 * (log_spread + 3.0 * robust);
    const double wider = std::max(1.0, mean / kKnown);
    for (int i = 0; i < 3; ++i) {
      Axis& x = filter.axes[i];
      const double s = wider * spread[i];
      const double hp = x.pp + gain[i] * x.pn;
      const double hv = x.pv + gain[i] * x.vn;
      const double hn = x.pn + gain[i] * x.nn;
      x.p += hp / s * error[i];
      x.v += hv / s * error[i];
      x.n += hn / s * error[i];
      x.pp -= hp * hp / s;
      x.pv -= hp * hv / s;
      x.vv -= hv * hv / s;
      x.pn -= hp * hn / s;
      x.vn -= hv * hn / s;
      x.nn -= hn * hn / s;
    }
  }
}

}  // namespace kinegraph
