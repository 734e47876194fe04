#include "core/identity/motion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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
// Coming and going, against an even spread: twice as often near the border,
// four times as seldom well inside, where only who was missed comes and goes.
// Over a disc of three to four metres that sums to one.
constexpr double kBorder = 0.75;  // m
constexpr double kInside = 1.5;   // m
const double kLogAtBorder = std::log(2.0);
const double kLogInside = -std::log(4.0);
// Of a prediction's distribution at least so much lies within the space.
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

// Of a normal distribution, between two limits.
double ShareWithin(double mean, double variance, double low, double high) {
  const double scale = std::sqrt(2.0 * variance);
  const double share =
      0.5 * (std::erf((high - mean) / scale) - std::erf((low - mean) / scale));
  return std::max(share, kLeastWithin);
}

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

  const Eigen::Vector3d expected_m =
      from.position_m + carried_s * from.velocity_mps;
  const Eigen::Vector3d dx = to.position_m - expected_m;
  const Eigen::Vector3d dv = to.velocity_mps - keeps * from.velocity_mps;
  double same = 0.0;
  double other = -std::log(space_.volume_m3());
  for (int axis = 0; axis < 3; ++axis) {
    same += LogDensity(dx(axis), dv(axis), covariance) -
            std::log(ShareWithin(expected_m(axis), covariance(0, 0),
                                 space_.low_m()(axis), space_.high_m()(axis)));
    other += LogNormal(to.velocity_mps(axis), variance + velocity_variance);
  }
  if (entries_at_border_) {
    other += space_.LogEntry(from.position_m) + space_.LogEntry(to.position_m);
  }
  const double share = std::min(0.5, std::pow(gap_s / kElsewhere, 3.0));
  const double ratio = same - other;
  // log((1 - share) exp(ratio) + share), without overflow.
  const double high = std::max(ratio + std::log1p(-share), std::log(share));
  const double low = std::min(ratio + std::log1p(-share), std::log(share));
  return high + std::log1p(std::exp(low - high));
}

UsedSpace::UsedSpace(const Eigen::Vector3d& low_m,
                     const Eigen::Vector3d& high_m)
    : low_m_(low_m), high_m_(high_m) {}

UsedSpace::UsedSpace(const std::vector<Tracklet>& tracklets)
    : low_m_(Eigen::Vector3d::Constant(1e12)), high_m_(-low_m_) {
  double count = 0.0;
  for (const Tracklet& tracklet : tracklets) {
    for (const TrackletFrame& frame : tracklet.frames) {
      low_m_ = low_m_.cwiseMin(frame.centre_m);
      high_m_ = high_m_.cwiseMax(frame.centre_m);
      origin_m_ += frame.centre_m;
      count += 1.0;
    }
  }
  if (count == 0.0) {
    low_m_ = high_m_ = Eigen::Vector3d::Zero();
  } else {
    origin_m_ /= count;
  }
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
    }
  }
  hull_m_ = ConvexHull(std::move(points));
  low_m_.array() -= kMarginAround;
  high_m_.array() += kMarginAround;
}

Eigen::Vector2d UsedSpace::OnFloor(const Eigen::Vector3d& position_m) const {
  return floor_ * (position_m - origin_m_);
}

double UsedSpace::DepthM(const Eigen::Vector3d& position_m) const {
  if (hull_m_.size() < 3) return 0.0;
  const Eigen::Vector2d at_m = OnFloor(position_m);
  double depth_m = std::numeric_limits<double>::max();
  for (size_t i = 0; i < hull_m_.size(); ++i) {
    const Eigen::Vector2d& a = hull_m_[i];
    const Eigen::Vector2d side = hull_m_[(i + 1) % hull_m_.size()] - a;
    depth_m = std::min(depth_m, Cross(side, at_m - a) / side.norm());
  }
  return depth_m;
}

double UsedSpace::LogEntry(const Eigen::Vector3d& position_m) const {
  const double inside = std::clamp(
      (DepthM(position_m) - kBorder) / (kInside - kBorder), 0.0, 1.0);
  return kLogAtBorder + inside * (kLogInside - kLogAtBorder);
}

}  // namespace kinegraph
