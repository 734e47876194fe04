#include "core/identity/motion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace kinegraph {
namespace {

// Standard deviations of the speed on each axis of people who stand, shuffle,
// stroll and stride (equally likely), and the time constants of velocity and
// activity.
constexpr std::array<double, 4> kSpeedSigmas = {0.1, 0.3, 0.6, 1.2};  // m/s
constexpr double kSpeedLasts = 1.0;                                   // s
constexpr double kActivityLasts = 1.5;                                // s
// Standard deviation of a measured velocity, corresponding to kStateSigmaM.
constexpr double kVelocitySigma = 0.2;  // m/s
constexpr double kMarginAround = 0.5;   // m
// Share of people who left and returned: (gap / kElsewhere)^3, at most nine in
// ten.
constexpr double kElsewhere = 5.0;  // s
constexpr double kMostElsewhere = 0.9;
// Heading. Of recorded people who stand, walk, hop and turn, half have turned
// by less than 0.1, 0.3 and 0.4 rad after 0.5, 1 and 2 s; the others are
// assumed to be uniform.
constexpr double kTurnSigma = 0.15;     // rad
constexpr double kTurnGrows = 0.2;      // rad / sqrt(s)
constexpr double kMostTurnSigma = 0.5;  // rad
constexpr double kKeepsFacing = 0.4;    // share, decaying with kKeepsLong
constexpr double kKeepsLong = 0.7;      // s
constexpr double kStillFacing = 0.35;   // share, decaying with kStillLong
constexpr double kStillLong = 20.0;     // s
constexpr double kWalkingSpeed = 1.0;   // m/s; heading follows motion
constexpr double kLeastAcross = 0.05;   // m; shorter: no direction
// Lower bound of the share of a prediction that lies within the occupied space.
constexpr double kLeastWithin = 0.05;

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

// Probability of a normal distribution between two limits, at least
// kLeastWithin.
double ShareWithin(double mean, double variance, double low, double high) {
  const double scale = std::sqrt(2.0 * variance);
  const double share =
      0.5 * (std::erf((high - mean) / scale) - std::erf((low - mean) / scale));
  return std::max(share, kLeastWithin);
}

// log of the sum of exponentials, without overflow.
template <size_t kCount>
double LogSum(const std::array<double, kCount>& logs) {
  const double most = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (const double one : logs) sum += std::exp(one - most);
  return most + std::log(sum);
}

using ActivityLogs = std::array<double, kSpeedSigmas.size()>;  // nats

// Log densities of a measured velocity under each activity.
ActivityLogs LogSpeeds(const Eigen::Vector2d& velocity_mps) {
  ActivityLogs logs;
  for (size_t k = 0; k < logs.size(); ++k) {
    const double variance =
        kSpeedSigmas[k] * kSpeedSigmas[k] + kVelocitySigma * kVelocitySigma;
    logs[k] = LogNormal(velocity_mps.x(), variance) +
              LogNormal(velocity_mps.y(), variance);
  }
  return logs;
}

// Distribution after a gap (Uhlenbeck and Ornstein 1930): covariance of
// position and velocity given both before it, including the errors of the two
// states. The first state's velocity is carried along.
struct Expected {
  Expected(double speed_sigma, double gap_s)
      : keeps(std::exp(-gap_s / kSpeedLasts)),
        carried_s(kSpeedLasts * (1.0 - keeps)) {
    const double tau = kSpeedLasts;
    const double variance = speed_sigma * speed_sigma;
    const double velocity_variance = kVelocitySigma * kVelocitySigma;
    covariance(0, 0) =
        variance * tau * tau *
            (2.0 * gap_s / tau - 3.0 + 4.0 * keeps - keeps * keeps) +
        2.0 * kStateSigmaM * kStateSigmaM +
        carried_s * carried_s * velocity_variance;
    covariance(0, 1) = covariance(1, 0) =
        variance * tau * (1.0 - keeps) * (1.0 - keeps) +
        carried_s * keeps * velocity_variance;
    covariance(1, 1) = variance * (1.0 - keeps * keeps) +
                       (1.0 + keeps * keeps) * velocity_variance;
  }

  double keeps;      // remaining share of the velocity
  double carried_s;  // effective time of carrying it along
  Eigen::Matrix2d covariance;
};

}  // namespace

IdentityMotion::IdentityMotion(const std::vector<Tracklet>& tracklets)
    : postures_({}, Eigen::Vector3d::UnitZ()) {
  double count = 0.0;
  for (const Tracklet& tracklet : tracklets) {
    for (const TrackletFrame& frame : tracklet.frames) {
      origin_m_ += frame.centre_m;
      count += 1.0;
    }
  }
  if (count == 0.0) return;
  origin_m_ /= count;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Tracklet& tracklet : tracklets) {
    for (const TrackletFrame& frame : tracklet.frames) {
      const Eigen::Vector3d away_m = frame.centre_m - origin_m_;
      spread += away_m * away_m.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  floor_.row(0) = axes.eigenvectors().col(2).transpose();
  floor_.row(1) = axes.eigenvectors().col(1).transpose();
  postures_ = PostureModel(
      tracklets,
      Eigen::Vector3d(floor_.row(0)).cross(Eigen::Vector3d(floor_.row(1))));
  low_m_.setConstant(1e12);
  high_m_ = -low_m_;
  for (const Tracklet& tracklet : tracklets) {
    for (const TrackletFrame& frame : tracklet.frames) {
      const Eigen::Vector2d at_m = OnFloor(frame.centre_m);
      low_m_ = low_m_.cwiseMin(at_m);
      high_m_ = high_m_.cwiseMax(at_m);
    }
  }
  low_m_.array() -= kMarginAround;
  high_m_.array() += kMarginAround;
}

double IdentityMotion::LogRatio(const MotionState& from, const MotionState& to,
                                double frame_s) const {
  const double gap_s = std::max(frame_s, ToSeconds(to.time - from.time));
  const Eigen::Vector2d velocity = floor_ * from.velocity_mps;
  const Eigen::Vector2d velocity_to = floor_ * to.velocity_mps;
  const ActivityLogs before = LogSpeeds(velocity);
  const double known = LogSum(before);
  const double lasts = std::exp(-gap_s / kActivityLasts);
  ActivityLogs same;
  for (size_t k = 0; k < same.size(); ++k) {
    const double share = std::exp(before[k] - known) * lasts +
                         (1.0 - lasts) / static_cast<double>(same.size());
    const Expected expected(kSpeedSigmas[k], gap_s);
    same[k] = std::log(share);
    for (int axis = 0; axis < 2; ++axis) {
      const double at =
          OnFloor(from.position_m)(axis) + expected.carried_s * velocity(axis);
      same[k] += LogDensity(OnFloor(to.position_m)(axis) - at,
                            velocity_to(axis) - expected.keeps * velocity(axis),
                            expected.covariance) -
                 std::log(ShareWithin(at, expected.covariance(0, 0),
                                      low_m_(axis), high_m_(axis)));
    }
  }
  const double other = LogSum(LogSpeeds(velocity_to)) -
                       std::log(static_cast<double>(kSpeedSigmas.size())) -
                       std::log((high_m_ - low_m_).prod());
  const double body = LogTurn(from, to, gap_s) +
                      postures_.LogRatio(from.posture, to.posture, gap_s);
  const double share =
      std::min(kMostElsewhere, std::pow(gap_s / kElsewhere, 3.0));
  return LogSum(std::array<double, 2>{
      LogSum(same) + body - other + std::log1p(-share), std::log(share)});
}

// After a gap a person mostly faces the same way, otherwise any direction. The
// change of heading of a walking person is already contained in the velocity.
double IdentityMotion::LogTurn(const MotionState& from, const MotionState& to,
                               double gap_s) const {
  const Eigen::Vector2d before = floor_ * from.across_m;
  const Eigen::Vector2d after = floor_ * to.across_m;
  if (before.norm() < kLeastAcross || after.norm() < kLeastAcross) return 0.0;
  const double turned = std::atan2(
      before.x() * after.y() - before.y() * after.x(), before.dot(after));
  const double sigma =
      std::min(kMostTurnSigma, kTurnSigma + kTurnGrows * std::sqrt(gap_s));
  const double keeps = kKeepsFacing * std::exp(-gap_s / kKeepsLong) +
                       kStillFacing * std::exp(-gap_s / kStillLong);
  const double ratio =
      1.0 - keeps +
      keeps * 2.0 * M_PI * std::exp(LogNormal(turned, sigma * sigma));
  const double speed = (floor_ * to.velocity_mps).norm() / kWalkingSpeed;
  return std::log(ratio) / (1.0 + speed * speed);
}

}  // namespace kinegraph
