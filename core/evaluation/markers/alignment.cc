#include "core/evaluation/markers/alignment.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Huber's loss is linear beyond this number of median residuals.
constexpr double kHuberMedians = 1.5;
// For speeds, beyond this number of root mean squares: most residuals are those
// of standing still and make the median small.
constexpr double kClockHuberRms = 6.0;

double HuberWeight(double residual, double limit) {
  const double size = std::abs(residual);
  return size <= limit ? 1.0 : limit / size;
}

// ---- Clock ------------------------------------------------------------------

// Speeds of all joints at uniform times; NaN where undefined.
struct SpeedGrid {
  SpeedGrid(const JointPaths& paths, double step_s, double half_s)
      : joints(paths.joint_count()), is_seen(joints) {
    const double begin = paths.times_s().front();
    const double length_s = paths.times_s().back() - begin;
    count = static_cast<int64_t>(length_s / step_s) + 1;
    speeds.reserve(static_cast<size_t>(count) * joints);
    for (int64_t i = 0; i < count; ++i) {
      const double time_s = begin + step_s * static_cast<double>(i);
      for (size_t j = 0; j < joints; ++j) {
        speeds.push_back(paths.Speed(time_s, j, half_s).value_or(kNan));
        is_seen[j] = is_seen[j] || !std::isnan(speeds.back());
      }
    }
  }

  size_t joints;
  std::vector<bool> is_seen;  // the joint ever has a speed
  int64_t count = 0;
  std::vector<double> speeds;
};

// Pearson's correlation of a(t + shift) and b(t), all joints together; NaN for
// fewer than `least` pairs.
double Correlation(const SpeedGrid& a, const SpeedGrid& b, int64_t shift,
                   double least) {
  double n = 0.0, sum_a = 0.0, sum_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  const int64_t begin = std::max<int64_t>(0, -shift);
  const int64_t end = std::min(b.count, a.count - shift);
  if (end <= begin) return kNan;
  const auto joints = static_cast<int64_t>(a.joints);
  const double* x = a.speeds.data() + (begin + shift) * joints;
  const double* y = b.speeds.data() + begin * joints;
  for (int64_t i = 0; i < (end - begin) * joints; ++i) {
    if (!(x[i] * y[i] >= 0.0)) continue;  // one of them is NaN
    n += 1.0;
    sum_a += x[i];
    sum_b += y[i];
    aa += x[i] * x[i];
    bb += y[i] * y[i];
    ab += x[i] * y[i];
  }
  if (n < least) return kNan;
  return (ab - sum_a * sum_b / n) /
         std::sqrt((aa - sum_a * sum_a / n) * (bb - sum_b * sum_b / n));
}

// Throws unless the standard deviation of some joint's speed reaches kLeastM_S.
// `whose`: "the tracks", for the message.
void RequireMotion(const JointPaths& paths, double half_s, const char* whose) {
  constexpr double kLeastM_S = 0.05;
  double most = 0.0;
  for (size_t j = 0; j < paths.joint_count(); ++j) {
    std::vector<double> speeds;
    for (const double time_s : paths.times_s()) {
      if (const auto speed = paths.Speed(time_s, j, half_s)) {
        speeds.push_back(*speed);
      }
    }
    if (!speeds.empty()) most = std::max(most, StandardDeviation(speeds));
  }
  if (most >= kLeastM_S) return;
  throw InputError(fmt::format(
      "no motion to align the clocks with: the speed of no joint of {} varies "
      "by more than {:.2f} m/s (standard deviation), expected {:.2f}; "
      "--align=world or none",
      whose, most, kLeastM_S));
}

// The time shift [s] at which the speeds' correlation is most significant, to
// one step of the grid.
double CoarseOffset(const JointPaths& truth, const JointPaths& tracks,
                    double half_s) {
  constexpr double kStepS = 0.04;
  constexpr double kLeastCorrelation = 0.5;
  constexpr double kAlike = 0.999;  // more adds no information
  // Required overlap: a second, or half of the shorter recording if that is
  // less; half of its speeds may be missing.
  const SpeedGrid a(truth, kStepS, half_s), b(tracks, kStepS, half_s);
  const double least_frames = std::min(
      1.0 / kStepS, 0.5 * static_cast<double>(std::min(a.count, b.count)));
  // Limits the number of shifts, each of which costs one pass over the speeds:
  // searching an hour takes a few seconds.
  constexpr double kMostWork = 4e9;
  const double pass = static_cast<double>(std::min(a.count, b.count)) *
                      static_cast<double>(a.joints);
  const auto reach = static_cast<int64_t>(kMostWork / std::max(1.0, pass));
  double best = 0.0, best_correlation = 0.0;
  int64_t best_shift = 0;
  double joints = 0.0;  // with a speed in both
  for (size_t j = 0; j < a.joints; ++j) {
    if (a.is_seen[j] && b.is_seen[j]) joints += 1.0;
  }
  for (int64_t shift = std::max(-b.count, -reach);
       shift <= std::min(a.count, reach); ++shift) {
    const double correlation =
        Correlation(a, b, shift, 0.5 * least_frames * joints);
    const auto overlap = static_cast<double>(
        std::min(b.count, a.count - shift) - std::max<int64_t>(0, -shift));
    // Significance of the correlation (Fisher's transform): a short overlap
    // easily correlates by chance.
    const double score =
        std::atanh(std::min(correlation, kAlike)) * std::sqrt(overlap);
    if (!(score > best)) continue;
    best = score;
    best_correlation = correlation;
    best_shift = shift;
  }
  if (best_correlation < kLeastCorrelation) {
    throw InputError(fmt::format(
        "the motions do not match at any shift of the clocks (speeds correlate "
        "by {:.2f} at best): another person or another recording?",
        best_correlation));
  }
  return truth.times_s().front() - tracks.times_s().front() +
         kStepS * static_cast<double>(best_shift);
}

// Sums of one pass over all speeds for the least squares in offset and drift.
struct ClockSums {
  Matrix2d information = Matrix2d::Zero();
  Vector2d gradient = Vector2d::Zero();
  std::vector<Vector2d> of_second, of_joint;  // parts of the gradient
  double squared = 0.0;
  double count = 0.0;

  // Covariance of the gradient from sums over seconds and over joints, because
  // errors of neighbouring frames are correlated and a joint's errors persist.
  Matrix2d Spread() const {
    Matrix2d spread = Matrix2d::Zero();
    for (const auto* parts : {&of_second, &of_joint}) {
      const auto parts_count = static_cast<double>(parts->size());
      if (parts_count < 2.0) continue;
      // Their sum is zero at the minimum, so a few parts underestimate the
      // variance.
      const double few = parts_count / (parts_count - 1.0);
      for (const Vector2d& part : *parts)
        spread += few * part * part.transpose();
    }
    return spread;
  }
};

constexpr double kSlopeStepS = 0.005;  // for the slope of the speed

ClockSums SumClock(const JointPaths& truth, const JointPaths& tracks,
                   const ClockFit& clock, double half_s, double limit) {
  ClockSums sums;
  const double begin_s = tracks.times_s().front();
  sums.of_second.assign(
      static_cast<size_t>(tracks.times_s().back() - begin_s) + 1,
      Vector2d::Zero());
  sums.of_joint.assign(tracks.joint_count(), Vector2d::Zero());
  for (const double time_s : tracks.times_s()) {
    const double at_s = clock.Map(time_s);
    for (size_t j = 0; j < tracks.joint_count(); ++j) {
      const auto found = tracks.Speed(time_s, j, half_s);
      const auto expected = truth.Speed(at_s, j, half_s);
      const auto before = truth.Speed(at_s - kSlopeStepS, j, half_s);
      const auto after = truth.Speed(at_s + kSlopeStepS, j, half_s);
      if (!found || !expected || !before || !after) continue;
      const double residual = *expected - *found;
      const double slope = (*after - *before) / (2.0 * kSlopeStepS);
      const Vector2d row(slope, slope * (time_s - clock.middle_s));
      const double weight = HuberWeight(residual, limit);
      const Vector2d gradient = weight * residual * row;
      sums.squared += residual * residual;
      sums.count += 1.0;
      sums.information += weight * row * row.transpose();
      sums.gradient += gradient;
      sums.of_second[static_cast<size_t>(time_s - begin_s)] += gradient;
      sums.of_joint[j] += gradient;
    }
  }
  return sums;
}

ClockFit FitClock(const JointPaths& truth, const JointPaths& tracks,
                  bool with_drift) {
  constexpr int kMostRounds = 50;
  constexpr double kStepToleranceS = 1e-7;
  // Truth and tracks are differentiated over the same time, long enough to
  // exclude motion that programs smooth away (above about 6 Hz) and movements
  // of the skin at impacts.
  const double half_s = std::max({truth.frame_s(), tracks.frame_s(), 0.05});
  RequireMotion(truth, half_s, "the ground truth");
  RequireMotion(tracks, half_s, "the tracks");
  ClockFit clock;
  clock.offset_s = CoarseOffset(truth, tracks, half_s);
  clock.middle_s = 0.5 * (tracks.times_s().front() + tracks.times_s().back());
  double limit = std::numeric_limits<double>::infinity();
  Matrix2d covariance = Matrix2d::Zero();
  for (int round = 0; round < kMostRounds; ++round) {
    const ClockSums sums = SumClock(truth, tracks, clock, half_s, limit);
    limit = kClockHuberRms * std::sqrt(sums.squared / sums.count);
    Matrix2d inverse = Matrix2d::Zero();
    inverse(0, 0) = 1.0 / sums.information(0, 0);
    if (with_drift) inverse = sums.information.inverse();
    const Vector2d step = -inverse * sums.gradient;
    if (!step.allFinite()) break;
    clock.offset_s += step[0];
    clock.drift += step[1];
    covariance = inverse * sums.Spread() * inverse;
    if (round > 2 && std::abs(step[0]) < kStepToleranceS) break;
  }
  clock.offset_sigma_s = std::sqrt(covariance(0, 0));
  clock.drift_sigma = std::sqrt(covariance(1, 1));
  return clock;
}

// ---- World ------------------------------------------------------------------

struct PointPair {
  Vector3d truth_m;
  Vector3d tracks_m;
  size_t joint = 0;
};

std::vector<PointPair> PointPairs(const JointPaths& truth,
                                  const JointPaths& tracks,
                                  const ClockFit& clock,
                                  const std::vector<bool>& use) {
  std::vector<PointPair> pairs;
  for (const double time_s : tracks.times_s()) {
    for (size_t j = 0; j < tracks.joint_count(); ++j) {
      if (!use[j]) continue;
      const auto found = tracks.At(time_s, j);
      if (!found) continue;
      const auto expected = truth.At(clock.Map(time_s), j);
      if (expected) pairs.push_back({*expected, *found, j});
    }
  }
  return pairs;
}

struct RigidFit {
  Matrix3d rotation;
  Vector3d translation_m;
  Vector3d middle_m;  // of the tracks
  std::vector<double> weights;
  double median_m = 0.0;

  Vector3d Apply(const Vector3d& point) const {
    return rotation * point + translation_m;
  }
};

// Weighted closed form (Umeyama 1991 without scale), repeated with Huber
// weights from the residuals. `sign` -1: the best mirror image.
RigidFit FitRigid(const std::vector<PointPair>& pairs, double sign) {
  constexpr int kRounds = 30;
  RigidFit fit;
  fit.weights.assign(pairs.size(), 1.0);
  std::vector<double> residuals(pairs.size());
  for (int round = 0; round < kRounds; ++round) {
    double sum = 0.0;
    Vector3d truth_m = Vector3d::Zero(), tracks_m = Vector3d::Zero();
    for (size_t i = 0; i < pairs.size(); ++i) {
      sum += fit.weights[i];
      truth_m += fit.weights[i] * pairs[i].truth_m;
      tracks_m += fit.weights[i] * pairs[i].tracks_m;
    }
    truth_m /= sum;
    tracks_m /= sum;
    Matrix3d product = Matrix3d::Zero();
    for (size_t i = 0; i < pairs.size(); ++i) {
      product += fit.weights[i] * (pairs[i].truth_m - truth_m) *
                 (pairs[i].tracks_m - tracks_m).transpose();
    }
    const Eigen::JacobiSVD<Matrix3d> svd(
        product, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double turn =
        (svd.matrixU() * svd.matrixV().transpose()).determinant();
    fit.rotation = svd.matrixU() *
                   Vector3d(1.0, 1.0, turn > 0.0 ? sign : -sign).asDiagonal() *
                   svd.matrixV().transpose();
    fit.translation_m = truth_m - fit.rotation * tracks_m;
    fit.middle_m = tracks_m;
    for (size_t i = 0; i < pairs.size(); ++i) {
      residuals[i] = (fit.Apply(pairs[i].tracks_m) - pairs[i].truth_m).norm();
    }
    fit.median_m = Quantile(residuals, 0.5);
    for (size_t i = 0; i < pairs.size(); ++i) {
      fit.weights[i] =
          HuberWeight(residuals[i], kHuberMedians * fit.median_m + 1e-9);
    }
  }
  return fit;
}

// Covariance of rotation and translation at the middle. Joints, not frames, are
// the independent samples, because their differences persist.
Eigen::Matrix<double, 6, 6> RigidCovariance(const std::vector<PointPair>& pairs,
                                            const RigidFit& fit,
                                            size_t joint_count) {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  Matrix6d information = Matrix6d::Zero();
  std::vector<Vector6d> of_joint(joint_count, Vector6d::Zero());
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Vector3d arm = fit.rotation * (pairs[i].tracks_m - fit.middle_m);
    Eigen::Matrix<double, 3, 6> jacobian;
    jacobian << 0.0, arm.z(), -arm.y(), 1, 0, 0,  //
        -arm.z(), 0.0, arm.x(), 0, 1, 0,          //
        arm.y(), -arm.x(), 0.0, 0, 0, 1;
    const Vector3d residual = fit.Apply(pairs[i].tracks_m) - pairs[i].truth_m;
    information += fit.weights[i] * jacobian.transpose() * jacobian;
    of_joint[pairs[i].joint] +=
        fit.weights[i] * jacobian.transpose() * residual;
  }
  Matrix6d spread = Matrix6d::Zero();
  for (const Vector6d& one : of_joint) spread += one * one.transpose();
  const Matrix6d inverse = information.inverse();
  return inverse * spread * inverse;
}

// The points must span two directions by more than the error of joints.
void RequireExtent(const std::vector<PointPair>& pairs) {
  constexpr double kLeastM = 0.03;
  constexpr size_t kLeastPoints = 3;
  Vector3d middle = Vector3d::Zero();
  for (const PointPair& pair : pairs) {
    middle += pair.truth_m / static_cast<double>(pairs.size());
  }
  Matrix3d spread = Matrix3d::Zero();
  for (const PointPair& pair : pairs) {
    spread += (pair.truth_m - middle) * (pair.truth_m - middle).transpose() /
              static_cast<double>(pairs.size());
  }
  const Eigen::JacobiSVD<Matrix3d> svd(spread);
  const double second_m = std::sqrt(svd.singularValues()[1]);
  if (pairs.size() >= kLeastPoints && second_m >= kLeastM) return;
  throw InputError(fmt::format(
      "the common joints are too small a body to register: {} points within "
      "{:.0f} mm (RMS) of a line; more joints (--joints), or --align=clock or "
      "none",
      pairs.size(), pairs.empty() ? 0.0 : 1000.0 * second_m));
}

// Thrown where a mirror image fits far better than any rotation.
class MirroredAxes : public InputError {
 public:
  using InputError::InputError;
};

WorldFit FitWorld(const JointPaths& truth, const JointPaths& tracks,
                  const ClockFit& clock, const std::vector<bool>& use) {
  // Ratio of the mirror image's median residual to that of the rotation below
  // which an axis counts as mirrored.
  constexpr double kFarBetter = 0.5;
  constexpr double kBadM = 0.04;  // median residual that calls for this test
  const std::vector<PointPair> pairs = PointPairs(truth, tracks, clock, use);
  RequireExtent(pairs);
  const RigidFit fit = FitRigid(pairs, 1.0);
  if (fit.median_m > kBadM) {
    const double mirrored_m = FitRigid(pairs, -1.0).median_m;
    if (mirrored_m < kFarBetter * fit.median_m) {
      throw MirroredAxes(fmt::format(
          "mirrored axes: the mirror image fits within {:.0f} mm, the motion "
          "itself within {:.0f} mm; an axis of one file is reversed, or left "
          "and right are exchanged",
          1000.0 * mirrored_m, 1000.0 * fit.median_m));
    }
  }
  WorldFit world;
  world.truth_from_tracks.linear() = fit.rotation;
  world.truth_from_tracks.translation() = fit.translation_m;
  const auto covariance = RigidCovariance(pairs, fit, tracks.joint_count());
  world.rotation_sigma_deg =
      kDegPerRad * std::sqrt(covariance.topLeftCorner<3, 3>().trace());
  world.translation_sigma_m =
      std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
  return world;
}

// ---- Clock and world --------------------------------------------------------

// Root mean square distance of the joints from their middle, the median over
// the frames that have all joints [m]; 0 without such frames, or for a single
// joint.
double BodySize(const JointPaths& paths) {
  std::vector<double> sizes_m;
  for (const double time_s : paths.times_s()) {
    std::vector<Vector3d> points;
    for (size_t j = 0; j < paths.joint_count(); ++j) {
      if (const auto at = paths.At(time_s, j)) points.push_back(*at);
    }
    if (points.size() < paths.joint_count() || points.size() < 2) continue;
    const auto count = static_cast<double>(points.size());
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& point : points) middle += point;
    middle /= count;
    double sum = 0.0;
    for (const Vector3d& point : points) sum += (point - middle).squaredNorm();
    sizes_m.push_back(std::sqrt(sum / count));
  }
  return sizes_m.empty() ? 0.0 : Quantile(sizes_m, 0.5);
}

void RequireSameUnits(const JointPaths& truth, const JointPaths& tracks) {
  constexpr double kMostRatio = 2.0;
  const double truth_m = BodySize(truth), tracks_m = BodySize(tracks);
  if (truth_m == 0.0 || tracks_m == 0.0) return;
  const double ratio = tracks_m / truth_m;
  if (ratio < kMostRatio && ratio > 1.0 / kMostRatio) return;
  throw InputError(fmt::format(
      "units differ: the body of the tracks is {:.4g} times as large as that "
      "of the ground truth ({:.4g} m against {:.4g} m from its middle); one "
      "file states a wrong unit",
      ratio, tracks_m, truth_m));
}

// Median distance over all joints and all frames of the tracks [m]; NaN if no
// joint has a position in both recordings at one time.
double MedianDistance(const JointPaths& truth, const JointPaths& tracks,
                      const ClockFit& clock, const WorldFit& world) {
  std::vector<double> distances_m;
  const std::vector<bool> all(tracks.joint_count(), true);
  for (const PointPair& pair : PointPairs(truth, tracks, clock, all)) {
    distances_m.push_back(
        (world.truth_from_tracks * pair.tracks_m - pair.truth_m).norm());
  }
  return Quantile(distances_m, 0.5);
}

// People present for at least a quarter of the frames of the longest track,
// longest first.
std::vector<TrackId> Candidates(const TrackSequence& tracks) {
  std::map<TrackId, int64_t> counts;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) ++counts[person.id];
  }
  std::vector<std::pair<int64_t, TrackId>> longest;
  for (const auto& [id, count] : counts) longest.push_back({-count, id});
  std::sort(longest.begin(), longest.end());
  std::vector<TrackId> ids;
  for (const auto& [count, id] : longest) {
    if (4 * count > longest.front().first) break;
    ids.push_back(id);
  }
  return ids;
}

void RequireOverlap(const JointPaths& truth, const JointPaths& tracks) {
  const auto& a = tracks.times_s();
  const auto& b = truth.times_s();
  if (a.back() >= b.front() && b.back() >= a.front()) return;
  throw InputError(fmt::format(
      "the times do not overlap: the tracks span {:.3f} .. {:.3f} s, the "
      "ground truth {:.3f} .. {:.3f} s; --align=both or clock finds the shift",
      a.front(), a.back(), b.front(), b.back()));
}

// A fit that was not requested is only informative and may fail; mirrored axes
// are always an error.
template <typename Fit>
auto Try(bool wanted, const Fit& fit) -> std::optional<decltype(fit())> {
  if (wanted) return fit();
  try {
    return fit();
  } catch (const MirroredAxes&) {
    throw;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

using PathPair = std::pair<JointPaths, JointPaths>;

Alignment AlignPerson(const JointPaths& truth, const JointPaths& tracks,
                      const std::vector<bool>& use, const PathPair& timing,
                      const AlignRequest& request) {
  const bool by_clock =
      request.align == Align::kBoth || request.align == Align::kClock;
  RequireSameUnits(truth, tracks);
  Alignment result;
  const auto clock = Try(by_clock, [&] {
    return FitClock(timing.first, timing.second, request.with_drift);
  });
  if (by_clock) {
    result.clock = *clock;
  } else {
    RequireOverlap(truth, tracks);
  }
  const ClockFit on = clock.value_or(ClockFit());
  const auto both = Try(request.align == Align::kBoth,
                        [&] { return FitWorld(truth, tracks, on, use); });
  if (request.align == Align::kBoth) result.world = *both;
  if (request.align == Align::kWorld) {
    result.world = FitWorld(truth, tracks, result.clock, use);
  }
  result.median_none_m = MedianDistance(truth, tracks, {}, {});
  result.median_clock_m = clock ? MedianDistance(truth, tracks, on, {}) : kNan;
  result.median_both_m =
      clock && both ? MedianDistance(truth, tracks, on, *both) : kNan;
  return result;
}

std::vector<int> Column(const JointPairs& joints, int JointPair::*side) {
  std::vector<int> places;
  for (const JointPair& pair : joints) places.push_back(pair.*side);
  return places;
}

}  // namespace

JointPaths::JointPaths(const TrackSequence& tracks, TrackId person,
                       const std::vector<int>& joints)
    : joint_count_(joints.size()) {
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& pose : frame.people) {
      if (pose.id != person) continue;
      times_s_.push_back(ToSeconds(frame.time));
      for (const int joint : joints) {
        samples_.push_back(pose.joints[joint]);
      }
    }
  }
  std::vector<double> steps_s;
  for (size_t i = 1; i < times_s_.size(); ++i) {
    steps_s.push_back(times_s_[i] - times_s_[i - 1]);
  }
  frame_s_ = steps_s.empty() ? 0.0 : Quantile(steps_s, 0.5);
}

std::optional<Vector3d> JointPaths::At(double time_s, size_t joint) const {
  // Times are rounded to a nanosecond.
  constexpr double kSameS = 2e-9;
  const auto next =
      std::lower_bound(times_s_.begin(), times_s_.end(), time_s - kSameS);
  if (next == times_s_.end()) return std::nullopt;
  const auto k = static_cast<size_t>(next - times_s_.begin());
  const Joint3d& right = Sample(k, joint);
  if (!right.present()) return std::nullopt;
  if (*next - time_s <= kSameS) return right.position_m;
  if (k == 0) return std::nullopt;
  const Joint3d& left = Sample(k - 1, joint);
  const double step_s = times_s_[k] - times_s_[k - 1];
  if (!left.present() || step_s > 1.5 * frame_s_) return std::nullopt;
  const double u = (time_s - times_s_[k - 1]) / step_s;
  const auto tangent = [&](size_t before,
                           size_t after) -> std::optional<Vector3d> {
    if (!Sample(before, joint).present() || !Sample(after, joint).present()) {
      return std::nullopt;
    }
    const double span_s = times_s_[after] - times_s_[before];
    if (span_s > 2.5 * frame_s_) return std::nullopt;
    return Vector3d(
        (Sample(after, joint).position_m - Sample(before, joint).position_m) *
        (step_s / span_s));
  };
  std::optional<Vector3d> m0, m1;
  if (k >= 2) m0 = tangent(k - 2, k);
  if (k + 1 < times_s_.size()) m1 = tangent(k - 1, k + 1);
  const Vector3d chord = right.position_m - left.position_m;
  if (!m0 || !m1) return Vector3d(left.position_m + u * chord);
  // Hermite's cubic.
  return Vector3d(left.position_m + u * *m0 +
                  u * u * (3.0 * chord - 2.0 * *m0 - *m1) +
                  u * u * u * (*m0 + *m1 - 2.0 * chord));
}

std::optional<double> JointPaths::Speed(double time_s, size_t joint,
                                        double half_s) const {
  const auto before = At(time_s - half_s, joint);
  if (!before) return std::nullopt;
  const auto after = At(time_s + half_s, joint);
  if (!after) return std::nullopt;
  return (*after - *before).norm() / (2.0 * half_s);
}

double WorldFit::rotation_deg() const {
  return kDegPerRad * Eigen::AngleAxisd(truth_from_tracks.linear()).angle();
}

TrackId OnlyPerson(const TrackSequence& tracks) {
  std::optional<TrackId> only;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      if (only && *only != person.id) {
        throw InputError(
            "has several people, expected one: kinegraph-convert --person=N "
            "picks one");
      }
      only = person.id;
    }
  }
  if (!only) throw InputError("has no people");
  return *only;
}

JointPaths TruthPaths(const TrackSequence& truth, const JointPairs& joints) {
  return {truth, OnlyPerson(truth), Column(joints, &JointPair::a)};
}

Alignment AlignRecordings(const TrackSequence& truth,
                          const std::vector<bool>& is_centre,
                          const TrackSequence& tracks,
                          const AlignRequest& request) {
  constexpr int64_t kLeastCentres = 3;
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  if (joints.empty())
    throw InputError("has no joint in common with the tracks");
  const JointPaths truth_paths = TruthPaths(truth, joints);
  // Toes and heads may be defined differently, with different speeds.
  const JointPairs by_body =
      CommonBodyJoints(truth.header.skeleton, tracks.header.skeleton);
  const JointPaths body_truth = TruthPaths(truth, by_body);
  std::vector<bool> use;
  for (const JointPair& pair : joints) {
    use.push_back(is_centre[pair.a]);
  }
  if (std::count(use.begin(), use.end(), true) < kLeastCentres) {
    use.assign(use.size(), true);
  }
  constexpr size_t kMostTried = 8;
  std::vector<TrackId> people = Candidates(tracks);
  if (request.person) {
    if (std::count(people.begin(), people.end(), *request.person) == 0) {
      throw InputError(fmt::format(
          "--person={}: the tracks have no such person who is present for a "
          "quarter of the longest track or more",
          request.person->value()));
    }
    people = {*request.person};
  }
  if (people.size() > kMostTried) people.resize(kMostTried);
  if (people.empty()) throw InputError("the tracks have no people");
  std::optional<Alignment> best;
  double least_m = std::numeric_limits<double>::infinity();
  std::optional<InputError> first_error;
  for (const TrackId person : people) {
    const JointPaths paths(tracks, person, Column(joints, &JointPair::b));
    try {
      const JointPaths body(tracks, person, Column(by_body, &JointPair::b));
      Alignment one =
          AlignPerson(truth_paths, paths, use, {body_truth, body}, request);
      const double median_m =
          MedianDistance(truth_paths, paths, one.clock, one.world);
      if (best && !(median_m < least_m)) continue;
      least_m = std::isnan(median_m) ? least_m : median_m;
      best = std::move(one);
      best->person = person;
    } catch (const InputError& error) {
      if (!first_error) first_error = error;
    }
  }
  if (!best) throw *first_error;
  best->joints = joints;
  return *best;
}

}  // namespace kinegraph
