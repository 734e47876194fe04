#include "solvers/scene/camera_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/evaluation/statistics.h"

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
  for (size_t v = 0; v < cameras_.size(); ++v) {
    const Camera& camera = cameras_[v];
    const double depth_m = camera.Depth(*middle);
    const auto middle_px = camera.Project(*middle);
    if (!(depth_m > 0.0) || !middle_px.has_value() ||
        !InImage(camera, *middle_px)) {
      continue;
    }
    std::vector<std::optional<Eigen::Vector2d>> projected(track_joint_.size());
    for (size_t j = 0; j < projected.size(); ++j) {
      if (track_joint_[j] < 0) continue;
      const Joint3d& joint =
          person.joints[static_cast<size_t>(track_joint_[j])];
      if (joint.status != JointStatus::kObserved) continue;
      projected[j] = camera.Project(joint.position_m);
    }
    Residuals& residuals = views_[v];
    ++residuals.people;
    const double px_per_m = camera.focal_px() / depth_m;
    const Detection* nearest = nullptr;
    double nearest_px = kGateM * px_per_m;
    for (const Detection& detection : frame.views[v].detections) {
      const double distance_px = Distance(projected, detection);
      if (distance_px >= nearest_px) continue;
      nearest_px = distance_px;
      nearest = &detection;
    }
    if (nearest == nullptr) continue;
    ++residuals.seen;
    residuals.px_per_m += px_per_m;
    for (size_t j = 0; j < projected.size(); ++j) {
      const Keypoint& point = nearest->joints[j];
      if (!projected[j].has_value() || !point.found ||
          point.confidence < kMinConfidence) {
        continue;
      }
      residuals.x_px.push_back(point.px.x() - projected[j]->x());
      residuals.y_px.push_back(point.px.y() - projected[j]->y());
    }
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
  // a centimetre or so; the camera itself pulls the pose, so that a residual
  // shows only a part of what is wrong.
  constexpr double kLeastM = 0.015;
  constexpr int64_t kEnoughPeople = 20;
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
                  "'%s' sees people %.1f px from where all cameras put them",
                  Printable(cameras_[v].name()).c_str(), shift_px);
    warnings.emplace_back(text.data());
  }
  return warnings;
}

}  // namespace kinegraph
