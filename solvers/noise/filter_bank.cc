#include "solvers/noise/filter_bank.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

constexpr double kLeastLevel = 1.0 / 40.0;
constexpr double kGreatestLevel = 1000.0;
// Where a filter knows less than this it knows nothing, and its variances would
// grow past the digits that a correction needs: it starts anew.
constexpr double kForgotten_s = 10.0;  // from frame to frame
constexpr double kUnknownM2 = 1e6;     // of a position

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
  // The part of the error that does not last; 0.02 of it and a tenth of a
  // millimetre keep it above zero.
  const double fresh_share = 1.02 - correlation.share;
  constexpr double kLeastVarianceM2 = 1e-8;
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
  if (started_ && (ToSeconds(time - time_) > kForgotten_s ||
                   filters_.back().axes[0].pp > kUnknownM2)) {
    *this = FilterBank(usual_);
  }
  if (!started_) {
    if (!point.has_value()) return;
    started_ = true;
    time_ = time;
    for (Filter& filter : filters_) {
      for (int i = 0; i < 3; ++i) filter.axes[i].p = point->position_m[i];
    }
  }
  constexpr double kKnown = 3.0;  // of the mean of e^2 / S
  const double dt_s = ToSeconds(time - time_);
  time_ = time;
  const double phi = std::exp(-dt_s / correlation.time_s);
  for (int level = 0; level < kLevelCount; ++level) {
    Filter& filter = filters_[level];
    Predict(dt_s, phi, usual_ * std::exp(LogLevel(level)), &filter);
    if (!point.has_value()) continue;
    const Innovation innovation = Innovate(filter, *point, correlation);
    const double mean = innovation.mean_square;
    const double robust =
        mean <= kKnown ? mean : kKnown * (1.0 + std::log(mean / kKnown));
    (*evidence)[level] -= 0.5 * (innovation.log_spread + 3.0 * robust);
    Correct(innovation, std::max(1.0, mean / kKnown), &filter);
  }
}

}  // namespace kinegraph
