#include "solvers/scene/camera_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/triangulation.h"
#include "solvers/scene/confidence_scale.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {
namespace {

// Farther than this from every detection a person was not seen: half a metre
// at their depth.
constexpr double kGateM = 0.5;
constexpr int kMinPersonJoints = 6;

// What is worth a warning. A detector's own bias, averaged over joints and
// directions, stays within a centimetre or so in each of the views that
// take part.
constexpr double kLeastM = 0.03;
constexpr int64_t kEnoughPeople = 15;
constexpr size_t kEnoughSamples = 300;  // joints
constexpr double kOfTheLargest = 0.6;

// Mean distance [px] of the joints that both have; infinite with too few.
double Distance(const std::vector<std::optional<Eigen::Vector2d>>& projected,
                const Detection& detection) {
  double sum = 0.0;
  int count = 0;
  for (size_t j = 0; j < projected.size(); ++j) {
    const Keypoint& point = detection.joints[j];
    if (!projected[j].has_value() || !point.found ||
        point.confidence < kMinJointConfidence) {
      continue;
    }
    sum += (point.px - *projected[j]).norm();
    ++count;
  }
  return count >= kMinPersonJoints ? sum / count
                                   : std::numeric_limits<double>::infinity();
}

bool InImage(const Camera& camera, const Eigen::Vector2d& px) {
  if (camera.width_px() <= 0) return true;
  return px.x() >= 0.0 && px.y() >= 0.0 && px.x() <= camera.width_px() &&
         px.y() <= camera.height_px();
}

// Velocities are taken over this time before and after: positions that are
// triangulated frame by frame are too rough for less.
constexpr TimeNs kSpan = 100'000'000;
// At less than half of it the velocity is not known.
constexpr double kLeastSpanS = 0.1;
// Over more it is no velocity.
constexpr double kMostSpanS = 0.5;
// What moves more slowly tells the detector's bias rather than the time.
constexpr double kLeastSpeedMps = 0.3;

// Where a sample's joint is in another frame.
std::optional<Eigen::Vector3d> PositionIn(const ClockCheck::Moment& moment,
                                          const ClockCheck::Sample& sample) {
  for (const auto& [id, joints] : moment.people) {
    if (id != sample.person) continue;
    if (!joints[sample.joint].present()) return std::nullopt;
    return joints[sample.joint].position_m;
  }
  return std::nullopt;
}

}  // namespace

ClockCheck::ClockCheck(CameraRig cameras)
    : cameras_(std::move(cameras)), late_(cameras_.size()) {}

void ClockCheck::SeeTracks(const TrackFrame& frame) {
  Moment& moment = recent_.emplace_back();
  moment.time = frame.time;
  for (const PersonPose& person : frame.people) {
    moment.people.emplace_back(person.id, person.joints);
  }
  while (!waiting_.empty() && waiting_.front().time + kSpan <= frame.time) {
    Weigh(waiting_.front());
    waiting_.pop_front();
  }
  const TimeNs needed =
      (waiting_.empty() ? frame.time : waiting_.front().time) - kSpan;
  while (recent_.size() > 1 && recent_[1].time <= needed) recent_.pop_front();
}

const ClockCheck::Moment& ClockCheck::NearestTo(TimeNs time) const {
  return *std::min_element(
      recent_.begin(), recent_.end(), [&](const Moment& a, const Moment& b) {
        return std::abs(a.time - time) < std::abs(b.time - time);
      });
}

void ClockCheck::Weigh(const Sample& sample) {
  const Moment& before = NearestTo(sample.time - kSpan);
  const Moment& after = NearestTo(sample.time + kSpan);
  const double span_s = ToSeconds(after.time - before.time);
  if (span_s < kLeastSpanS || span_s > kMostSpanS) return;
  const auto from = PositionIn(before, sample);
  const auto to = PositionIn(after, sample);
  if (!from.has_value() || !to.has_value()) return;
  const Camera& camera = cameras_[sample.view];
  const auto from_px = camera.Project(*from);
  const auto to_px = camera.Project(*to);
  if (!from_px.has_value() || !to_px.has_value()) return;
  const Eigen::Vector2d px_per_s = (*to_px - *from_px) / span_s;
  const double m_per_px = camera.Depth(*to) / camera.focal_px();
  const double speed_mps = px_per_s.norm() * m_per_px;
  if (speed_mps < kLeastSpeedMps) return;
  const double late_s =
      sample.residual_px.dot(px_per_s) / px_per_s.squaredNorm();
  const double squared_speed = sample.weight * speed_mps * speed_mps;
  Lateness& lateness = late_[sample.view];
  lateness.late_s.emplace_back(late_s - sample.told_late_s, squared_speed);
  lateness.weight += sample.weight;
  lateness.squared_speed += squared_speed;
}

std::vector<ClockCheck::View> ClockCheck::Views() const {
  std::vector<View> views;
  for (const Lateness& lateness : late_) {
    View& view = views.emplace_back();
    view.samples = lateness.late_s.size();
    if (view.samples == 0) continue;
    view.late_s = WeightedMedian(lateness.late_s);
    view.error_m = std::abs(view.late_s) *
                   std::sqrt(lateness.squared_speed / lateness.weight);
  }
  return views;
}

CameraCheck::CameraCheck(CameraRig cameras, const Skeleton& detections,
                         const Skeleton& tracks)
    : cameras_(std::move(cameras)),
      track_joint_(MapByName(tracks, detections)),
      clocks_(cameras_),
      views_(cameras_.size()) {}

void CameraCheck::set_metre(double metre) {
  if (metre == metre_) return;
  for (Camera& camera : cameras_) {
    CameraParameters parameters = camera.parameters();
    parameters.t *= metre_ / metre;
    camera = Camera(std::move(parameters));
  }
  clocks_ = ClockCheck(cameras_);
  metre_ = metre;
}

void CameraCheck::SeeDetections(const DetectionFrame& frame) {
  if (frames_fed_++ % stride_ != 0) return;
  if (confidences_.size() < kConfidences) {
    CollectConfidences(frame, &confidences_);
    confidence_scale_ = ConfidenceScale(confidences_);
  }
  KeptFrame& kept = waiting_[frame.frame];
  kept = {frame, static_cast<double>(stride_)};
  ScaleConfidences(confidence_scale_, &kept.frame);
  if (++frames_kept_ % kFramesAStride == 0) stride_ *= 2;
}

void CameraCheck::SeeTracks(const TrackFrame& in_world) {
  TrackFrame scaled;
  if (metre_ != 1.0) {
    scaled = in_world;
    for (PersonPose& person : scaled.people) {
      for (Joint3d& joint : person.joints) joint.position_m /= metre_;
    }
  }
  const TrackFrame& frame = metre_ == 1.0 ? in_world : scaled;
  // What was fed before this frame and never written is not waited for.
  const auto at = waiting_.find(frame.frame);
  waiting_.erase(waiting_.begin(), waiting_.lower_bound(frame.frame));
  if (at != waiting_.end()) {
    for (const PersonPose& person : frame.people) Compare(at->second, person);
    waiting_.erase(at);
  }
  clocks_.SeeTracks(frame);
}

void CameraCheck::Compare(const KeptFrame& kept, const PersonPose& person) {
  const auto middle = MeanPosition(person.joints);
  if (!middle.has_value()) return;
  std::vector<const Detection*> seen(cameras_.size(), nullptr);
  std::vector<char> shown(cameras_.size(), 0);
  for (size_t v = 0; v < cameras_.size(); ++v) {
    const auto middle_px = cameras_[v].Project(*middle);
    if (!middle_px.has_value() || !InImage(cameras_[v], *middle_px)) continue;
    shown[v] = 1;
    seen[v] = NearestTo(kept.frame.views[v], cameras_[v], person);
  }
  const auto others = [&](size_t v) {
    int count = 0;
    for (size_t u = 0; u < seen.size(); ++u) count += u != v && seen[u];
    return count;
  };
  for (size_t v = 0; v < cameras_.size(); ++v) {
    if (!shown[v] || others(v) < (is_pair() ? 1 : 2)) continue;
    ++views_[v].people;
    if (seen[v] == nullptr) continue;
    ++views_[v].seen;
    views_[v].px_per_m += cameras_[v].focal_px() / cameras_[v].Depth(*middle);
    AddResiduals(kept, person, seen, v);
  }
}

// The detection of a view that lies nearest a person; null beyond the gate.
const Detection* CameraCheck::NearestTo(const ViewDetections& view,
                                        const Camera& camera,
                                        const PersonPose& person) const {
  std::vector<std::optional<Eigen::Vector2d>> projected(track_joint_.size());
  double depth_m = 0.0;
  for (size_t j = 0; j < projected.size(); ++j) {
    if (track_joint_[j] < 0) continue;
    const Joint3d& joint = person.joints[static_cast<size_t>(track_joint_[j])];
    if (joint.status != JointStatus::kObserved) continue;
    projected[j] = camera.Project(joint.position_m);
    depth_m = std::max(depth_m, camera.Depth(joint.position_m));
  }
  if (!(depth_m > 0.0)) return nullptr;
  const Detection* nearest = nullptr;
  double nearest_px = kGateM * camera.focal_px() / depth_m;
  for (const Detection& detection : view.detections) {
    const double distance_px = Distance(projected, detection);
    if (distance_px >= nearest_px) continue;
    nearest_px = distance_px;
    nearest = &detection;
  }
  return nearest;
}

// What view `v` sees, less where the other views alone put it: a camera that
// takes part in a pose hides a part of its own error. One other view alone puts
// nothing anywhere; of a pair both take part, and either hides half of what
// they differ by, across each other's epipolar lines.
void CameraCheck::AddResiduals(const KeptFrame& kept, const PersonPose& person,
                               const std::vector<const Detection*>& seen,
                               size_t v) {
  // A few joints of many people say as much as all.
  constexpr size_t kEvery = 3;
  const auto counts = [](const Keypoint& point) {
    return point.found && point.confidence >= kMinJointConfidence;
  };
  std::vector<PointMeasurement> measurements;
  for (size_t j = v % kEvery; j < track_joint_.size(); j += kEvery) {
    const Keypoint& own = seen[v]->joints[j];
    if (track_joint_[j] < 0 || !counts(own)) continue;
    measurements.clear();
    double others_s = 0.0;  // after the view's own picture
    for (size_t u = 0; u < seen.size(); ++u) {
      if (u == v && !is_pair()) continue;
      if (seen[u] == nullptr || !counts(seen[u]->joints[j])) continue;
      const auto ideal = cameras_[u].Undistort(seen[u]->joints[j].px);
      if (!ideal.has_value()) continue;
      measurements.push_back({&cameras_[u], *ideal, 1.0});
      others_s += ToSeconds(kept.frame.views[u].capture_time -
                            kept.frame.views[v].capture_time);
    }
    if (measurements.size() < 2) continue;
    ++views_[v].tried;
    TriangulationOptions options;
    options.min_angle_rad = 0.2;  // else depth is a guess
    const TriangulationResult point =
        TriangulateDlt({measurements.data(), measurements.size()}, options);
    if (!point.ok()) continue;
    const auto px = cameras_[v].Project(point.point_m);
    if (!px.has_value()) continue;
    const Eigen::Vector2d residual_px =
        (is_pair() ? 2.0 : 1.0) * (own.px - *px);
    views_[v].x_px.emplace_back(residual_px.x(), kept.weight);
    views_[v].y_px.emplace_back(residual_px.y(), kept.weight);
    if (is_pair()) continue;  // where people are when, two views do not tell
    clocks_.Add({v, kept.frame.time, person.id,
                 static_cast<size_t>(track_joint_[j]), residual_px, kept.weight,
                 -others_s / static_cast<double>(measurements.size())});
  }
}

std::vector<CameraCheck::View> CameraCheck::Views() const {
  const std::vector<ClockCheck::View> clocks = clocks_.Views();
  std::vector<View> views;
  for (const Residuals& residuals : views_) {
    View& view = views.emplace_back();
    view.clock = clocks[views.size() - 1];
    view.people = residuals.people;
    view.seen = residuals.seen;
    // Views that stand together place nothing but what they see wrongly.
    if (2 * static_cast<int64_t>(residuals.x_px.size()) < residuals.tried ||
        residuals.x_px.empty()) {
      continue;
    }
    view.median_x_px = WeightedMedian(residuals.x_px);
    view.median_y_px = WeightedMedian(residuals.y_px);
    view.px_per_m = residuals.px_per_m / static_cast<double>(residuals.seen);
  }
  return views;
}

std::vector<CameraWarning> CameraCheck::Warnings() const {
  using Kind = CameraWarning::Kind;
  std::vector<CameraWarning> warnings;
  const std::vector<View> views = Views();
  double largest_s = 0.0;  // of the clocks
  for (const View& view : views) {
    largest_s = std::max(largest_s, std::abs(view.clock.late_s));
  }
  for (size_t v = 0; v < views.size(); ++v) {
    const View& view = views[v];
    if (view.people < kEnoughPeople) continue;
    const std::string name = "'" + Printable(cameras_[v].name()) + "'";
    if (static_cast<double>(view.seen) <
        kStrangerShare * static_cast<double>(view.people)) {
      warnings.push_back(
          {Kind::kHardlySeen,
           fmt::format("{} sees {} of {} people where the others put them",
                       name, view.seen, view.people)});
      continue;
    }
    const double shift_px = std::hypot(view.median_x_px, view.median_y_px);
    if (view.px_per_m > 0.0 && shift_px >= kLeastM * view.px_per_m) {
      warnings.push_back(
          {Kind::kElsewhere,
           fmt::format(
               "{} sees people {:.1f} px from where the others put them", name,
               shift_px)});
    }
    // One clock that is off makes the others look so, to a smaller part.
    const double late_s = view.clock.late_s;
    if (view.clock.samples >= kEnoughSamples && view.clock.error_m >= kLeastM &&
        std::abs(late_s) > kOfTheLargest * largest_s) {
      warnings.push_back(
          {Kind::kOffBeat,
           fmt::format("{} sees people about {:.0f} ms {} than the others",
                       name, 1e3 * std::abs(late_s),
                       late_s > 0.0 ? "later" : "earlier")});
    }
  }
  return warnings;
}

}  // namespace kinegraph
