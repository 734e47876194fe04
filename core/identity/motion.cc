#include "core/identity/motion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace kinegraph {
namespace {

// Standard deviations of the speed on each axis of people who stand, shuffle,
// stroll and stride (equally likely), and the times for which a velocity and an
// activity last.
constexpr std::array<double, 4> kSpeedSigmas = {0.1, 0.3, 0.6, 1.2};  // m/s
constexpr double kSpeedLasts = 1.0;                                   // s
constexpr double kDoingLasts = 1.5;                                   // s
// The trunk's centre sways about a straight walk, and is measured worst just
// where a person is lost.
constexpr double kPositionSigma = 0.08;  // m
constexpr double kVelocitySigma = 0.2;   // m/s
constexpr double kStateSeconds = 0.3;
constexpr double kMarginAround = 0.5;  // m
// Share of people who come back from elsewhere: (gap / kElsewhere)^3, at most
// nine in ten.
constexpr double kElsewhere = 5.0;  // s
constexpr double kMostElsewhere = 0.9;
// Density of coming and going relative to a uniform one: twice near the border,
// a quarter well inside, where only missed people appear. Normalised by its
// mean over the space, so it is no evidence where all of the space is near the
// border.
constexpr double kBorder = 0.75;  // m
constexpr double kInside = 1.5;   // m
const double kLogAtBorder = std::log(2.0);
const double kLogInside = -std::log(4.0);
// Heading. Of recorded people who stand, walk, hop and turn, half have turned
// by less than 0.1, 0.3 and 0.4 rad after 0.5, 1 and 2 s; the others are taken
// as uniform.
constexpr double kTurnSigma = 0.15;     // rad
constexpr double kTurnGrows = 0.2;      // rad / sqrt(s)
constexpr double kMostTurnSigma = 0.5;  // rad
constexpr double kKeepsFacing = 0.4;    // share, fading as kKeepsLong
constexpr double kKeepsLong = 0.7;      // s
constexpr double kStillFacing = 0.35;   // share, fading as kStillLong
constexpr double kStillLong = 20.0;     // s
constexpr double kWalkingSpeed = 1.0;   // m/s; faces where it goes
constexpr double kLeastAcross = 0.05;   // m, shorter tells no direction
// A prediction has at least this share within the space.
constexpr double kLeastWithin = 0.05;

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
  Eigen::Vector3d across = Eigen::Vector3d::Zero();
  for (size_t k = begin; k < end; ++k) {
    const double time_s = ToSeconds(tracklet.frames[k].time - at) - mean_s;
    spread += time_s * time_s;
    moment += time_s * (tracklet.frames[k].centre_m - mean);
    across += tracklet.frames[k].across_m / count;
  }
  // Shrunk towards rest where the frames span too little time to tell a
  // velocity.
  constexpr double kUsualSpeed = 0.9;  // m/s
  const double rest = count * kPositionSigma * kPositionSigma /
                      (12.0 * kUsualSpeed * kUsualSpeed);
  MotionState state;
  state.time = at;
  state.velocity_mps = moment / (spread + rest);
  state.position_m = mean - mean_s * state.velocity_mps;
  state.across_m = across;
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

// Of a normal distribution, between two limits.
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

using Doing = std::array<double, kSpeedSigmas.size()>;  // nats

// Log densities of a measured velocity under each activity.
Doing LogSpeeds(const Eigen::Vector2d& velocity_mps) {
  Doing logs;
  for (size_t k = 0; k < logs.size(); ++k) {
    const double variance =
        kSpeedSigmas[k] * kSpeedSigmas[k] + kVelocitySigma * kVelocitySigma;
    logs[k] = LogNormal(velocity_mps.x(), variance) +
              LogNormal(velocity_mps.y(), variance);
  }
  return logs;
}

// After a gap (Uhlenbeck and Ornstein 1930): covariance of position and
// velocity given both before it, with the errors of the two states. The first
// one's velocity is carried along.
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
        2.0 * kPositionSigma * kPositionSigma +
        carried_s * carried_s * velocity_variance;
    covariance(0, 1) = covariance(1, 0) =
        variance * tau * (1.0 - keeps) * (1.0 - keeps) +
        carried_s * keeps * velocity_variance;
    covariance(1, 1) = variance * (1.0 - keeps * keeps) +
                       (1.0 + keeps * keeps) * velocity_variance;
  }

  double keeps;      // share of the velocity
  double carried_s;  // how long it is carried along
  Eigen::Matrix2d covariance;
};

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Andrew 1979; counterclockwise, without points on its sides.
std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
              return std::make_pair(a.x(), a.y()) <
                     std::make_pair(b.x(), b.y());
            });
  std::vector<Eigen::Vector2d> hull;
  for (int half = 0; half < 2; ++half) {
    const size_t begin = hull.size();
    for (const Eigen::Vector2d& point : points) {
      while (hull.size() >= begin + 2 &&
             Cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <=
                 0.0) {
        hull.pop_back();
      }
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

// Not yet divided by the mean.
double LogEntryAt(double depth_m) {
  const double inside =
      std::clamp((depth_m - kBorder) / (kInside - kBorder), 0.0, 1.0);
  return kLogAtBorder + inside * (kLogInside - kLogAtBorder);
}

// Of the frames begin .. end - 1 the last.
MotionState StateBefore(const Tracklet& tracklet, size_t begin, size_t end) {
  const TimeNs at = tracklet.frames[end - 1].time;
  size_t from = end - 1;
  while (from > begin &&
         ToSeconds(at - tracklet.frames[from - 1].time) <= kStateSeconds) {
    --from;
  }
  MotionState state = FitState(tracklet, from, end, at);
  state.posture = PostureOf(tracklet, end - 1);
  return state;
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
  MotionState state = FitState(tracklet, begin, end, at);
  state.posture = PostureOf(tracklet, begin);
  return state;
}

MotionState StateAtEnd(const Tracklet& tracklet) {
  return StateBefore(tracklet, tracklet.clean_begin(), tracklet.clean_end());
}

MotionState StateUpTo(const Tracklet& tracklet, TimeNs time) {
  const auto end = std::upper_bound(
      tracklet.frames.begin() + 1, tracklet.frames.end(), time,
      [](TimeNs t, const TrackletFrame& frame) { return t < frame.time; });
  return StateBefore(tracklet, 0,
                     static_cast<size_t>(end - tracklet.frames.begin()));
}

double IdentityMotion::LogRatio(const MotionState& from, const MotionState& to,
                                double frame_s) const {
  const double gap_s = std::max(frame_s, ToSeconds(to.time - from.time));
  const Eigen::Vector2d velocity = space_.AlongFloor(from.velocity_mps);
  const Eigen::Vector2d velocity_to = space_.AlongFloor(to.velocity_mps);
  const Doing before = LogSpeeds(velocity);
  const double known = LogSum(before);
  const double lasts = std::exp(-gap_s / kDoingLasts);
  Doing same;
  for (size_t k = 0; k < same.size(); ++k) {
    const double share = std::exp(before[k] - known) * lasts +
                         (1.0 - lasts) / static_cast<double>(same.size());
    const Expected expected(kSpeedSigmas[k], gap_s);
    same[k] = std::log(share);
    for (int axis = 0; axis < 2; ++axis) {
      const double at = space_.OnFloor(from.position_m)(axis) +
                        expected.carried_s * velocity(axis);
      same[k] +=
          LogDensity(space_.OnFloor(to.position_m)(axis) - at,
                     velocity_to(axis) - expected.keeps * velocity(axis),
                     expected.covariance) -
          std::log(ShareWithin(at, expected.covariance(0, 0),
                               space_.low_m()(axis), space_.high_m()(axis)));
    }
  }
  double other = LogSum(LogSpeeds(velocity_to)) -
                 std::log(static_cast<double>(kSpeedSigmas.size())) -
                 std::log(space_.area_m2());
  if (entries_at_border_) {
    other += space_.LogEntry(from.position_m) + space_.LogEntry(to.position_m);
  }
  const double body = LogTurn(from, to, gap_s) +
                      postures_.LogRatio(from.posture, to.posture, gap_s);
  const double share =
      std::min(kMostElsewhere, std::pow(gap_s / kElsewhere, 3.0));
  return LogSum(std::array<double, 2>{
      LogSum(same) + body - other + std::log1p(-share), std::log(share)});
}

// After a gap a person mostly faces the same way, or any other. The turn of a
// walking person is already in the velocity.
double IdentityMotion::LogTurn(const MotionState& from, const MotionState& to,
                               double gap_s) const {
  const Eigen::Vector2d before = space_.AlongFloor(from.across_m);
  const Eigen::Vector2d after = space_.AlongFloor(to.across_m);
  if (before.norm() < kLeastAcross || after.norm() < kLeastAcross) return 0.0;
  const double turned = std::atan2(Cross(before, after), before.dot(after));
  const double sigma =
      std::min(kMostTurnSigma, kTurnSigma + kTurnGrows * std::sqrt(gap_s));
  const double keeps = kKeepsFacing * std::exp(-gap_s / kKeepsLong) +
                       kStillFacing * std::exp(-gap_s / kStillLong);
  const double ratio =
      1.0 - keeps +
      keeps * 2.0 * M_PI * std::exp(LogNormal(turned, sigma * sigma));
  const double speed =
      space_.AlongFloor(to.velocity_mps).norm() / kWalkingSpeed;
  return std::log(ratio) / (1.0 + speed * speed);
}

UsedSpace::UsedSpace(const Eigen::Vector2d& low_m,
                     const Eigen::Vector2d& high_m)
    : low_m_(low_m), high_m_(high_m), log_mean_entry_(kLogAtBorder) {
  floor_.leftCols<2>().setIdentity();
}

UsedSpace::UsedSpace(const std::vector<Tracklet>& tracklets)
    : low_m_(Eigen::Vector2d::Constant(1e12)), high_m_(-low_m_) {
  double count = 0.0;
  for (const Tracklet& tracklet : tracklets) {
    for (const TrackletFrame& frame : tracklet.frames) {
      origin_m_ += frame.centre_m;
      count += 1.0;
    }
  }
  if (count > 0.0) origin_m_ /= count;
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
  std::vector<Eigen::Vector2d> points;
  for (const Tracklet& tracklet : tracklets) {
    for (const TrackletFrame& frame : tracklet.frames) {
      points.push_back(OnFloor(frame.centre_m));
      low_m_ = low_m_.cwiseMin(points.back());
      high_m_ = high_m_.cwiseMax(points.back());
    }
  }
  if (points.empty()) low_m_ = high_m_ = Eigen::Vector2d::Zero();
  hull_m_ = ConvexHull(std::move(points));
  low_m_.array() -= kMarginAround;
  high_m_.array() += kMarginAround;
  log_mean_entry_ = LogMeanEntry();
}

double UsedSpace::LogMeanEntry() const {
  constexpr int kSteps = 32;  // on each axis
  double sum = 0.0;
  int count = 0;
  for (int x = 0; x < kSteps; ++x) {
    for (int y = 0; y < kSteps; ++y) {
      const Eigen::Vector2d share((x + 0.5) / kSteps, (y + 0.5) / kSteps);
      const double depth_m =
          DepthOnFloor(low_m_ + share.cwiseProduct(high_m_ - low_m_));
      if (depth_m < 0.0) continue;
      sum += std::exp(LogEntryAt(depth_m));
      ++count;
    }
  }
  return count == 0 ? kLogAtBorder : std::log(sum / count);
}

Eigen::Vector2d UsedSpace::OnFloor(const Eigen::Vector3d& position_m) const {
  return floor_ * (position_m - origin_m_);
}

Eigen::Vector3d UsedSpace::Up() const {
  return Eigen::Vector3d(floor_.row(0)).cross(Eigen::Vector3d(floor_.row(1)));
}

Eigen::Vector2d UsedSpace::AlongFloor(const Eigen::Vector3d& direction) const {
  return floor_ * direction;
}

double UsedSpace::DepthM(const Eigen::Vector3d& position_m) const {
  return DepthOnFloor(OnFloor(position_m));
}

double UsedSpace::DepthOnFloor(const Eigen::Vector2d& at_m) const {
  if (hull_m_.size() < 3) return 0.0;
  double depth_m = std::numeric_limits<double>::max();
  for (size_t i = 0; i < hull_m_.size(); ++i) {
    const Eigen::Vector2d& a = hull_m_[i];
    const Eigen::Vector2d side = hull_m_[(i + 1) % hull_m_.size()] - a;
    depth_m = std::min(depth_m, Cross(side, at_m - a) / side.norm());
  }
  return depth_m;
}

double UsedSpace::LogEntry(const Eigen::Vector3d& position_m) const {
  return LogEntryAt(DepthM(position_m)) - log_mean_entry_;
}

}  // namespace kinegraph
