#include "solvers/noise/filter_bank.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

constexpr double kLeastLevel = 1.0 / 40.0;
constexpr double kGreatestLevel = 1000.0;
// The part of a point's error that never lasts: of its variance, and a tenth of
// a millimetre, which keeps it above zero.
constexpr double kFreshShare = 0.02;
constexpr double kLeastVarianceM2 = 1e-8;

// Whether a correction would lose what stands in the last two of the 16 digits
// of a variance: what is predicted is so vague, as after a pause of hours, that
// nothing is known.
bool LosesDigits(double predicted_m2, double variance_m2) {
  return predicted_m2 > 1e14 * (kFreshShare * variance_m2 + kLeastVarianceM2);
}

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

void FilterBank::Predict(double dt_s, double phi, double power,
                         Filter* filter) {
  const double dt = dt_s;
  const double q = power;
  for (Axis& x : filter->axes) {
    x.p += dt * x.v;
    x.n *= phi;
    x.pp += dt * (2.0 * x.pv + dt * x.vv) + q * dt * dt * dt / 3.0;
    x.pv += dt * x.vv + 0.5 * q * dt * dt;
    x.vv += q * dt;
    x.pn = phi * (x.pn + dt * x.vn);
    x.vn *= phi;
    x.nn = phi * phi * x.nn + 1.0 - phi * phi;
  }
}

FilterBank::Innovation FilterBank::Innovate(
    const Filter& filter, const FramePoint& point,
    const ErrorCorrelation& correlation) {
  const double fresh_share = 1.0 + kFreshShare - correlation.share;
  Innovation innovation;
  for (int i = 0; i < 3; ++i) {
    const Axis& x = filter.axes[i];
    const double variance = point.covariance_m2(i, i);
    const double gain = std::sqrt(correlation.share * variance);
    const double error = point.position_m[i] - x.p - gain * x.n;
    const double spread = x.pp + 2.0 * gain * x.pn + gain * gain * x.nn +
                          fresh_share * variance + kLeastVarianceM2;
    innovation.gain[i] = gain;
    innovation.error[i] = error;
    innovation.spread[i] = spread;
    innovation.mean_square += error * error / spread / 3.0;
    innovation.log_spread += std::log(spread);
  }
  return innovation;
}

void FilterBank::Correct(const Innovation& innovation, double wider,
                         Filter* filter) {
  for (int i = 0; i < 3; ++i) {
    Axis& x = filter->axes[i];
    const double gain = innovation.gain[i];
    const double error = innovation.error[i];
    const double s = wider * innovation.spread[i];
    const double hp = x.pp + gain * x.pn;
    const double hv = x.pv + gain * x.vn;
    const double hn = x.pn + gain * x.nn;
    x.p += hp / s * error;
    x.v += hv / s * error;
    x.n += hn / s * error;
    x.pp -= hp * hp / s;
    x.pv -= hp * hv / s;
    x.vv -= hv * hv / s;
    x.pn -= hp * hn / s;
    x.vn -= hv * hn / s;
    x.nn -= hn * hn / s;
  }
}

void FilterBank::Add(TimeNs time, const std::optional<FramePoint>& point,
                     const ErrorCorrelation& correlation, Levels* evidence) {
  const auto start = [&] {
    filters_ = {};
    for (Filter& filter : filters_) {
      for (int i = 0; i < 3; ++i) filter.axes[i].p = point->position_m[i];
    }
  };
  if (!started_) {
    if (!point.has_value()) return;
    started_ = true;
    time_ = time;
    start();
  }
  constexpr double kKnown = 3.0;  // of the mean of e^2 / S
  const double dt_s = ToSeconds(time - time_);
  time_ = time;
  const double phi = std::exp(-dt_s / correlation.time_s);
  for (int level = 0; level < kLevelCount; ++level) {
    Predict(dt_s, phi, usual_ * std::exp(LogLevel(level)), &filters_[level]);
  }
  if (!point.has_value()) return;
  for (int i = 0; i < 3; ++i) {
    // The last level is driven most.
    if (LosesDigits(filters_.back().axes[i].pp, point->covariance_m2(i, i))) {
      start();
    }
  }
  for (int level = 0; level < kLevelCount; ++level) {
    Filter& filter = filters_[level];
    const Innovation innovation = Innovate(filter, *point, correlation);
    const double mean = innovation.mean_square;
    const double robust =
        mean <= kKnown ? mean : kKnown * (1.0 + std::log(mean / kKnown));
    (*evidence)[level] -= 0.5 * (innovation.log_spread + 3.0 * robust);
    Correct(innovation, std::max(1.0, mean / kKnown), &filter);
  }
}

}  // namespace kinegraph
