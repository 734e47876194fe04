#include "solvers/scene/camera_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/evaluation/statistics.h"
#include "core/geometry/triangulation.h"

namespace kinegraph {
namespace {

// Farther than this from every detection a person was not seen: half a metre
// at their depth.
constexpr double kGateM = 0.5;
constexpr double kMinConfidence = 0.3;
constexpr int kMinJoints = 6;

// Mean distance [px] of the joints that both have; infinite with too few.
double Distance(const std::vector<std::optional<Eigen::Vector2d>>& projected,
                const Detection& detection) {
  double sum = 0.0;
  int count = 0;
  for (size_t j = 0; j < projected.size(); ++j) {
    const Keypoint& point = detection.joints[j];
    if (!projected[j].has_value() || !point.found ||
        point.confidence < kMinConfidence) {
      continue;
    }
    sum += (point.px - *projected[j]).norm();
    ++count;
  }
  return count >= kMinJoints ? sum / count
                             : std::numeric_limits<double>::infinity();
}

bool InImage(const Camera& camera, const Eigen::Vector2d& px) {
  if (camera.width_px() <= 0) return true;
  return px.x() >= 0.0 && px.y() >= 0.0 && px.x() <= camera.width_px() &&
         px.y() <= camera.height_px();
}

}  // namespace

CameraCheck::CameraCheck(CameraRig cameras, const Skeleton& detections,
                         const Skeleton& tracks)
    : cameras_(std::move(cameras)),
      track_joint_(MapByName(tracks, detections)),
      views_(cameras_.size()) {}

void CameraCheck::SeeDetections(const DetectionFrame& frame) {
  if (frames_fed_++ % kStride != 0 || frames_kept_ >= kMostFrames) return;
  ++frames_kept_;
  waiting_[frame.frame] = frame;
}

void CameraCheck::SeeTracks(const TrackFrame& frame) {
  // What was fed before this frame and never written is not waited for.
  const auto at = waiting_.find(frame.frame);
  waiting_.erase(waiting_.begin(), waiting_.lower_bound(frame.frame));
  if (at == waiting_.end()) return;
  for (const PersonPose& person : frame.people) Compare(at->second, person);
  waiting_.erase(at);
}

void CameraCheck::Compare(const DetectionFrame& frame,
                          const PersonPose& person) {
  const auto middle = MeanPosition(person.joints);
  if (!middle.has_value()) return;
  std::vector<const Detection*> seen(cameras_.size(), nullptr);
  std::vector<char> shown(cameras_.size(), 0);
  for (size_t v = 0; v < cameras_.size(); ++v) {
    const auto middle_px = cameras_[v].Project(*middle);
    if (!middle_px.has_value() || !InImage(cameras_[v], *middle_px)) continue;
    shown[v] = 1;
    seen[v] = NearestTo(frame.views[v], cameras_[v], person);
  }
  const auto others = [&](size_t v) {
    int count = 0;
    for (size_t u = 0; u < seen.size(); ++u) count += u != v && seen[u];
    return count;
  };
  for (size_t v = 0; v < cameras_.size(); ++v) {
    if (!shown[v] || others(v) < 2) continue;
    ++views_[v].people;
    if (seen[v] == nullptr) continue;
    ++views_[v].seen;
    views_[v].px_per_m += cameras_[v].focal_px() / cameras_[v].Depth(*middle);
    AddResiduals(seen, v);
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
// takes part in a pose hides a part of its own error.
void CameraCheck::AddResiduals(const std::vector<const Detection*>& seen,
                               size_t v) {
  // A few joints of many people say as much as all.
  constexpr size_t kEvery = 3;
  const auto counts = [](const Keypoint& point) {
    return point.found && point.confidence >= kMinConfidence;
  };
  std::vector<PointMeasurement> measurements;
  for (size_t j = v % kEvery; j < track_joint_.size(); j += kEvery) {
    const Keypoint& own = seen[v]->joints[j];
    if (track_joint_[j] < 0 || !counts(own)) continue;
    measurements.clear();
    for (size_t u = 0; u < seen.size(); ++u) {
      if (u == v || seen[u] == nullptr || !counts(seen[u]->joints[j])) continue;
      const auto ideal = cameras_[u].Undistort(seen[u]->joints[j].px);
      if (ideal.has_value())
        measurements.push_back({&cameras_[u], *ideal, 1.0});
    }
    if (measurements.size() < 2) continue;
    TriangulationOptions options;
    options.min_angle_rad = 0.2;  // else depth is a guess
    const TriangulationResult point =
        TriangulateDlt({measurements.data(), measurements.size()}, options);
    if (!point.ok()) continue;
    const auto px = cameras_[v].Project(point.point_m);
    if (!px.has_value()) continue;
    views_[v].x_px.push_back(own.px.x() - px->x());
    views_[v].y_px.push_back(own.px.y() - px->y());
  }
}

std::vector<CameraCheck::View> CameraCheck::Views() const {
  std::vector<View> views;
  for (const Residuals& residuals : views_) {
    View& view = views.emplace_back();
    view.people = residuals.people;
    view.seen = residuals.seen;
    if (residuals.x_px.empty()) continue;
    view.median_x_px = Quantile(residuals.x_px, 0.5);
    view.median_y_px = Quantile(residuals.y_px, 0.5);
    view.px_per_m = residuals.px_per_m / static_cast<double>(residuals.seen);
  }
  return views;
}

std::vector<std::string> CameraCheck::Warnings() const {
  // A detector's own bias, averaged over joints and directions, stays within
  // a centimetre or so in each of the views that take part.
  constexpr double kLeastM = 0.03;
  constexpr int64_t kEnoughPeople = 15;
  constexpr double kHardlySeen = 0.2;
  std::vector<std::string> warnings;
  const std::vector<View> views = Views();
  for (size_t v = 0; v < views.size(); ++v) {
    const View& view = views[v];
    if (view.people < kEnoughPeople) continue;
    std::array<char, 200> text{};
    if (static_cast<double>(view.seen) <
        kHardlySeen * static_cast<double>(view.people)) {
      std::snprintf(text.data(), text.size(),
                    "'%s' sees %lld of %lld people where the others put them",
                    Printable(cameras_[v].name()).c_str(),
                    static_cast<long long>(view.seen),
                    static_cast<long long>(view.people));
      warnings.emplace_back(text.data());
      continue;
    }
    const double shift_px = std::hypot(view.median_x_px, view.median_y_px);
    if (shift_px < kLeastM * view.px_per_m || view.px_per_m <= 0.0) continue;
    std::snprintf(text.data(), text.size(),
                  "'%s' sees people %.1f px from where the others put them",
                  Printable(cameras_[v].name()).c_str(), shift_px);
    warnings.emplace_back(text.data());
  }
  return warnings;
}

}  // namespace kinegraph
