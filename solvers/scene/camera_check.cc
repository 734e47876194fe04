#include "solvers/scene/camera_check.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/weighted_quantile.h"
#include "core/evaluation/statistics.h"
#include "solvers/cameras/segments.h"
#include "solvers/scene/plausible.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {
namespace {

// Thresholds of a warning. A detector's bias, averaged over joints and
// directions, stays below about a centimetre in each contributing view.
constexpr double kLeastM = 0.03;
constexpr int64_t kEnoughPeople = 15;
constexpr size_t kEnoughInMotion = 60;  // segments
constexpr double kCertainSigmas = 4.0;
// Clock errors below this fraction of the largest are not reported.
constexpr double kOfTheLargest = 0.6;

// Confidence-weighted mean distance [px] of the common joints; infinite if
// there are fewer than `fewest`.
double Distance(const std::vector<std::optional<Eigen::Vector2d>>& projected,
                const Detection& detection, std::ptrdiff_t fewest) {
  double sum = 0.0;
  double weight = 0.0;
  std::ptrdiff_t count = 0;
  for (size_t j = 0; j < projected.size(); ++j) {
    const Keypoint& point = detection.joints[j];
    if (!projected[j].has_value() || !point.found) continue;
    sum += point.confidence * (point.px - *projected[j]).norm();
    weight += point.confidence;
    ++count;
  }
  return count >= fewest && weight > 0.0
             ? sum / weight
             : std::numeric_limits<double>::infinity();
}

bool InImage(const Camera& camera, const Eigen::Vector2d& px) {
  if (camera.width_px() <= 0) return true;
  return px.x() >= 0.0 && px.y() >= 0.0 && px.x() <= camera.width_px() &&
         px.y() <= camera.height_px();
}

// The state of a segment from its measurements alone; nullopt if fewer than two
// views see it, if their rays are nearly parallel, so that depth is uncertain,
// or if the fit fails.
std::optional<SegmentState> StateBy(const CameraRig& cameras,
                                    const SceneSegments& segments,
                                    const MotionSegment& segment) {
  constexpr double kMinAngleRad = 0.2;
  std::vector<Eigen::Vector3d> rays;
  for (const SegmentMeasurement& one : segment.measurements) {
    rays.push_back(
        (PositionOf(segment) - cameras[one.view_idx].centre()).normalized());
  }
  const bool apart =
      std::any_of(rays.begin(), rays.end(), [&](const Eigen::Vector3d& ray) {
        return ray.cross(rays.front()).norm() > std::sin(kMinAngleRad);
      });
  SegmentState state = segment.state;
  if (!apart || !SolveSegment(cameras, NoChanges(cameras.size()), segment,
                              segments.noise_scale, SegmentOptions(), &state)) {
    return std::nullopt;
  }
  return state;
}

// The measurements of one view minus the prediction of the others, by segment.
struct Residuals {
  int64_t tried = 0;  // segments to be predicted
  std::vector<double> x_px;
  std::vector<double> y_px;
  double px_per_m = 0.0;  // sum over segments
  // Velocities in the image, and their squares at the segment's depth
  // [m^2/s^2].
  std::vector<Eigen::Vector2d> px_per_s;
  std::vector<double> squared_mps;

  // `state` is estimated from the other views, and `factor` is 1; with only two
  // views it is estimated from both, and `factor` is 2 (ResidualsOf). The
  // velocity is that of the estimate from all views, because it does not depend
  // on this view's mean error over the segment. `own`: the measurements of this
  // view.
  void Add(const Camera& camera, const MotionSegment& segment,
           const SegmentState& state,
           const std::vector<SegmentMeasurement>& own, double factor) {
    Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();
    for (const SegmentMeasurement& one : own) {
      const auto r = SegmentResidual(camera, CameraChange::Zero(), segment,
                                     state, one, 1.0);
      if (!r.has_value()) return;
      residual_px -= factor * one.sigma_px * *r;
    }
    residual_px /= static_cast<double>(own.size());
    Matrix23d by_point;
    if (!ProjectChanged(camera, CameraChange::Zero(), state.head<3>(),
                        &by_point)) {
      return;
    }
    x_px.push_back(residual_px.x());
    y_px.push_back(residual_px.y());
    const double scale = camera.focal_px() / camera.Depth(state.head<3>());
    px_per_m += scale;
    px_per_s.push_back(by_point * segment.state.segment<3>(3));
    squared_mps.push_back(px_per_s.back().squaredNorm() / (scale * scale));
  }

  // Sets the view's offset and the lag of its images relative to the recorded
  // times. The offset is removed before the lag is estimated, because a person
  // walking in one direction confounds the two.
  void Describe(CameraCheck::View* view) const {
    // At lower speeds the detector's bias exceeds the effect of a clock error.
    constexpr double kLeastSpeedMps = 0.3;
    view->x_px = Quantile(x_px, 0.5);
    view->y_px = Quantile(y_px, 0.5);
    view->px_per_m = px_per_m / static_cast<double>(x_px.size());
    std::vector<WeightedValue> late_s;  // weighted by squared speed
    double sum = 0.0;
    double squares = 0.0;
    for (size_t i = 0; i < x_px.size(); ++i) {
      if (squared_mps[i] < kLeastSpeedMps * kLeastSpeedMps) continue;
      const Eigen::Vector2d left_px(x_px[i] - view->x_px, y_px[i] - view->y_px);
      late_s.emplace_back(left_px.dot(px_per_s[i]) / px_per_s[i].squaredNorm(),
                          squared_mps[i]);
      sum += squared_mps[i];
      squares += squared_mps[i] * squared_mps[i];
    }
    view->in_motion = late_s.size();
    if (late_s.empty()) return;
    view->late_s = WeightedMedian(late_s);
    view->late_m = std::abs(view->late_s) *
                   std::sqrt(sum / static_cast<double>(view->in_motion));
    // Standard error of the median of normal values, from their median absolute
    // deviation and their effective number under the weights.
    for (WeightedValue& one : late_s) {
      one.first = std::abs(one.first - view->late_s);
    }
    view->late_sigma_s =
        1.2533 * 1.4826 * WeightedMedian(late_s) * std::sqrt(squares) / sum;
  }
};

// The detection of a view nearest to a person; null if it is half a metre or
// more away at the person's depth, i.e. the person was not detected, or if no
// detection has enough joints in common with the person.
const Detection* NearestTo(const ViewDetections& view, const Camera& camera,
                           const PersonPose& person,
                           const std::vector<int>& track_joint) {
  constexpr double kGateM = 0.5;
  std::vector<std::optional<Eigen::Vector2d>> projected(track_joint.size());
  double depth_m = 0.0;
  for (size_t j = 0; j < projected.size(); ++j) {
    if (track_joint[j] < 0) continue;
    const Joint3d& joint = person.joints[track_joint[j]];
    if (joint.status != JointStatus::kObserved) continue;
    projected[j] = camera.Project(joint.position_m);
    depth_m = std::max(depth_m, camera.Depth(joint.position_m));
  }
  if (!(depth_m > 0.0)) return nullptr;
  // Six joints, or all that both skeletons have.
  const std::ptrdiff_t fewest = std::min<std::ptrdiff_t>(
      6, std::count_if(track_joint.begin(), track_joint.end(),
                       [](int j) { return j >= 0; }));
  const Detection* nearest = nullptr;
  double nearest_px = kGateM * camera.focal_px() / depth_m;
  for (const Detection& detection : view.detections) {
    const double distance_px = Distance(projected, detection, fewest);
    if (distance_px >= nearest_px) continue;
    nearest_px = distance_px;
    nearest = &detection;
  }
  return nearest;
}

// Assigns detections to a person by distance alone, regardless of the tracker's
// matches, because a camera with errors has few matches.
FrozenFrame MatchesOf(const CameraRig& cameras, const DetectionFrame& frame,
                      const PersonPose& person,
                      const std::vector<int>& track_joint,
                      std::vector<CameraCheck::View>* views) {
  FrozenFrame matches;
  matches.frame = frame.frame;
  matches.time = frame.time;
  const auto middle = MeanPosition(person.joints);
  if (!middle.has_value()) return matches;
  std::vector<char> shown(cameras.size(), 0);
  std::vector<char> found(cameras.size(), 0);
  for (size_t v = 0; v < cameras.size(); ++v) {
    const auto middle_px = cameras[v].Project(*middle);
    if (!middle_px.has_value() || !InImage(cameras[v], *middle_px)) continue;
    shown[v] = 1;
    const Detection* nearest =
        NearestTo(frame.views[v], cameras[v], person, track_joint);
    if (nearest == nullptr) continue;
    found[v] = 1;
    matches.detections.push_back({static_cast<int>(v), nearest->index_in_file});
  }
  const auto all = std::count(found.begin(), found.end(), 1);
  for (size_t v = 0; v < cameras.size(); ++v) {
    if (!shown[v] || all - found[v] < (cameras.size() == 2 ? 1 : 2)) continue;
    ++(*views)[v].people;
    (*views)[v].seen += found[v];
  }
  return matches;
}

// A camera that contributes to a pose hides part of its own error, so each view
// is compared with the prediction of the others alone. A single other view
// determines no 3D position: with two views both contribute, and each hides
// half of the disagreement, perpendicular to the epipolar lines. Of many other
// views only some are used.
Residuals ResidualsOf(const CameraRig& cameras, const SceneSegments& segments,
                      size_t view) {
  const bool is_pair = cameras.size() == 2;
  std::vector<char> asked(cameras.size(), 0);
  for (const auto& [a, b] : ComparedPairs(cameras.size())) {
    if (a == view || b == view) asked[a] = asked[b] = 1;
  }
  Residuals residuals;
  for (const MotionSegment& segment : segments.segments) {
    MotionSegment others = segment;
    std::vector<SegmentMeasurement> own;
    others.measurements.clear();
    for (const SegmentMeasurement& one : segment.measurements) {
      const bool is_own = one.view_idx == static_cast<int>(view);
      if (is_own) own.push_back(one);
      if (is_own ? is_pair : asked[one.view_idx]) {
        others.measurements.push_back(one);
      }
    }
    if (own.empty()) continue;
    ++residuals.tried;
    const auto state = StateBy(cameras, segments, others);
    if (!state.has_value()) continue;
    residuals.Add(cameras[view], others, *state, own, is_pair ? 2.0 : 1.0);
  }
  return residuals;
}

bool IsCertain(const CameraCheck::View& view) {
  return view.in_motion >= kEnoughInMotion &&
         std::abs(view.late_s) > kCertainSigmas * view.late_sigma_s;
}

}  // namespace

CameraCheck::CameraCheck(CameraRig cameras, const Skeleton& detections,
                         const Skeleton& tracks)
    : cameras_(std::move(cameras)),
      track_joint_(MapByName(tracks, detections)) {
  header_.skeleton = detections;
  header_.view_names.resize(cameras_.size());
}

void CameraCheck::See(const DetectionFrame& seen, const TrackFrame& tracked) {
  constexpr TimeNs kBurst = 240'000'000;  // one segment, plus rounding
  constexpr size_t kMostFrames = 600;
  constexpr int64_t kMaxStride = int64_t{1} << 40;
  if (last_time_.has_value()) {
    // A clock that stops or steps back begins a new burst.
    const TimeNs step = seen.time - *last_time_;
    elapsed_ += step > 0 ? step : kBurst;
  }
  last_time_ = seen.time;
  const int64_t burst = elapsed_ / kBurst;
  if (burst % stride_ != 0) return;
  kept_.push_back({burst, seen, tracked.people});
  if (kept_.size() < kMostFrames || stride_ >= kMaxStride) return;
  stride_ *= 2;
  kept_.erase(
      std::remove_if(kept_.begin(), kept_.end(),
                     [&](const Kept& one) { return one.burst % stride_ != 0; }),
      kept_.end());
}

std::vector<CameraCheck::View> CameraCheck::Views(double metre) const {
  const CameraRig cameras = Rescaled(cameras_, 1.0 / metre);
  std::vector<View> views(cameras.size());
  DetectionSequence seen;
  seen.header = header_;
  std::map<TrackId, FrozenPerson> people;
  for (const Kept& kept : kept_) {
    seen.frames.push_back(kept.seen);
    for (PersonPose person : kept.people) {
      for (Joint3d& joint : person.joints) joint.position_m /= metre;
      people[person.id].frames.push_back(
          MatchesOf(cameras, kept.seen, person, track_joint_, &views));
    }
  }
  FrozenMatches matches;
  for (auto& one : people) matches.people.push_back(std::move(one.second));
  SegmentOptions options;
  options.max_segments = 300;
  const SceneSegments segments = MakeSegments(
      cameras, WithUsualConfidences(std::move(seen)), matches, options);
  for (size_t v = 0; v < cameras.size(); ++v) {
    const Residuals residuals = ResidualsOf(cameras, segments, v);
    View& view = views[v];
    // Views too close together to predict positions would only reproduce their
    // own errors.
    const auto count = static_cast<int64_t>(residuals.x_px.size());
    if (2 * count < residuals.tried || count == 0) continue;
    residuals.Describe(&view);
    // Two views cannot separate a clock error from a displacement.
    if (cameras.size() == 2) view.in_motion = 0;
  }
  return views;
}

std::vector<CameraWarning> CameraCheck::Warnings(double metre) const {
  using Kind = CameraWarning::Kind;
  std::vector<CameraWarning> warnings;
  const std::vector<View> views = Views(metre);
  double largest_s = 0.0;  // the largest significant clock error
  for (const View& view : views) {
    if (!IsCertain(view)) continue;
    largest_s = std::max(largest_s, std::abs(view.late_s));
  }
  for (size_t v = 0; v < views.size(); ++v) {
    const View& view = views[v];
    const std::string name = "'" + Printable(cameras_[v].name()) + "'";
    if (HardlyAny(view.seen, view.people)) {
      warnings.push_back(
          {Kind::kHardlySeen,
           fmt::format(
               "{} sees {} of {} people where the other views place them", name,
               view.seen, view.people)});
      continue;
    }
    if (view.people < kEnoughPeople) continue;
    const double shift_px = std::hypot(view.x_px, view.y_px);
    if (view.px_per_m > 0.0 && shift_px >= kLeastM * view.px_per_m) {
      warnings.push_back(
          {Kind::kElsewhere,
           fmt::format(
               "{} sees people {:.1f} px from where the other views place them",
               name, shift_px)});
    }
    // One wrong clock makes the others appear wrong, to a lesser extent.
    if (IsCertain(view) && view.late_m >= kLeastM &&
        std::abs(view.late_s) > kOfTheLargest * largest_s) {
      warnings.push_back(
          {Kind::kOffBeat,
           fmt::format("{} sees people about {:.0f} ms {} than the other views",
                       name, 1e3 * std::abs(view.late_s),
                       view.late_s > 0.0 ? "later" : "earlier")});
    }
  }
  return warnings;
}

}  // namespace kinegraph
