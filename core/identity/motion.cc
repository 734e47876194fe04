#include "core/identity/motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

// Walking with turns and stops: speed in each axis, and how long it lasts.
constexpr double kSpeedSigma = 0.9;  // m/s
constexpr double kSpeedLasts = 1.0;  // s
// The trunk's centre sways against a straight walk, and is measured badly just
// where a person is lost.
constexpr double kPositionSigma = 0.08;  // m
constexpr double kVelocitySigma = 0.35;  // m/s
constexpr double kStateSeconds = 0.3;
constexpr double kMarginAround = 0.5;  // m
// Share of people who come back from elsewhere: (gap / kElsewhere)^3, at most
// a half.
constexpr double kElsewhere = 5.0;  // s

MotionState FitState(const Tracklet& tracklet, size_t begin, size_t end,
                     TimeNs at) {
  double mean_s = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const auto count = static_cast<double>(end - begin);
  for (size_t k = begin; k < end; ++k) {
    mean_s += ToSeconds(tracklet.frames[k].time - at) / count;
    mean += tracklet.frames[k].centre_m / count;
  }
  double spread = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (size_t k = begin; k < end; ++k) {
    const double time_s = ToSeconds(tracklet.frames[k].time - at) - mean_s;
    spread += time_s * time_s;
    moment += time_s * (tracklet.frames[k].centre_m - mean);
  }
  // Drawn to rest where the frames span too little to tell a velocity.
  const double rest = count * kPositionSigma * kPositionSigma /
                      (12.0 * kSpeedSigma * kSpeedSigma);
  MotionState state;
  state.time = at;
  state.velocity_mps = moment / (spread + rest);
  state.position_m = mean - mean_s * state.velocity_mps;
  return state;
}

// log of a zero-mean normal density over (dx, dv).
double LogDensity(double dx, double dv, const Eigen::Matrix2d& covariance) {
  const Eigen::Vector2d x(dx, dv);
  return -0.5 * (x.dot(covariance.inverse() * x) +
                 std::log(covariance.determinant())) -
         std::log(2.0 * M_PI);
}

double LogNormal(double x, double variance) {
  return -0.5 * (x * x / variance + std::log(2.0 * M_PI * variance));
}

}  // namespace

MotionState StateAtBegin(const Tracklet& tracklet) {
  const size_t begin = tracklet.clean_begin();
  const TimeNs at = tracklet.frames[begin].time;
  size_t end = begin + 1;
  while (end < tracklet.clean_end() &&
         ToSeconds(tracklet.frames[end].time - at) <= kStateSeconds) {
    ++end;
  }
  return FitState(tracklet, begin, end, at);
}

MotionState StateAtEnd(const Tracklet& tracklet) {
  const size_t end = tracklet.clean_end();
  const TimeNs at = tracklet.frames[end - 1].time;
  size_t begin = end - 1;
  while (begin > tracklet.clean_begin() &&
         ToSeconds(at - tracklet.frames[begin - 1].time) <= kStateSeconds) {
    --begin;
  }
  return FitState(tracklet, begin, end, at);
}

double IdentityMotion::LogRatio(const MotionState& from, const MotionState& to,
                                double frame_s) const {
  const double gap_s = std::max(frame_s, ToSeconds(to.time - from.time));
  const double tau = kSpeedLasts;
  const double keeps = std::exp(-gap_s / tau);
  const double variance = kSpeedSigma * kSpeedSigma;
  // Uhlenbeck and Ornstein 1930: covariance of position and velocity after
  // the gap, given both before it.
  Eigen::Matrix2d covariance;
  covariance(0, 0) = variance * tau * tau *
                     (2.0 * gap_s / tau - 3.0 + 4.0 * keeps - keeps * keeps);
  covariance(0, 1) = covariance(1, 0) =
      variance * tau * (1.0 - keeps) * (1.0 - keeps);
  covariance(1, 1) = variance * (1.0 - keeps * keeps);
  // Errors of the two states: the first one's velocity is carried along.
  const double carried_s = tau * (1.0 - keeps);
  const double velocity_variance = kVelocitySigma * kVelocitySigma;
  covariance(0, 0) += 2.0 * kPositionSigma * kPositionSigma +
                      carried_s * carried_s * velocity_variance;
  covariance(0, 1) += carried_s * keeps * velocity_variance;
  covariance(1, 0) = covariance(0, 1);
  covariance(1, 1) += (1.0 + keeps * keeps) * velocity_variance;

  const Eigen::Vector3d dx =
      to.position_m - from.position_m - carried_s * from.velocity_mps;
  const Eigen::Vector3d dv = to.velocity_mps - keeps * from.velocity_mps;
  double same = 0.0;
  double other = -std::log(volume_m3_);
  for (int axis = 0; axis < 3; ++axis) {
    same += LogDensity(dx(axis), dv(axis), covariance);
    other += LogNormal(to.velocity_mps(axis), variance + velocity_variance);
  }
  const double share = std::min(0.5, std::pow(gap_s / kElsewhere, 3.0));
  const double ratio = same - other;
  // log((1 - share) exp(ratio) + share), without overflow.
  const double high = std::max(ratio + std::log1p(-share), std::log(share));
  const double low = std::min(ratio + std::log1p(-share), std::log(share));
  return high + std::log1p(std::exp(low - high));
}

double VolumeOf(const std::vector<Tracklet>& tracklets) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e12);
  Eigen::Vector3d high = -low;
  for (const Tracklet& tracklet : tracklets) {
    for (const TrackletFrame& frame : tracklet.frames) {
      low = low.cwiseMin(frame.centre_m);
      high = high.cwiseMax(frame.centre_m);
    }
  }
  return ((high - low).cwiseMax(0.0).array() + 2.0 * kMarginAround).prod();
}

}  // namespace kinegraph
