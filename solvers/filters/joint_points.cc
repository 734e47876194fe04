#include "solvers/filters/joint_points.h"

#include <algorithm>

#include "solvers/graph/assembler.h"

namespace kinegraph {

JointPoints::JointPoints(const SceneModel& scene, PointKind kind,
                         PointCovariances covariances,
                         const RobustTriangulationOptions& robust,
                         const GraphOptions& noise)
    : cameras_(scene.cameras),
      skeleton_(scene.skeleton),
      kind_(kind),
      covariances_(covariances),
      robust_(robust),
      noise_(noise) {}

void JointPoints::Find(const EstimatorFrame& frame,
                       std::vector<std::optional<JointPoint>>* points,
                       PersonPose* person) {
  if (frame.has_initial) {
    centre_ = MeanPosition(frame.initial).value_or(centre_);
  }
  points->assign(static_cast<size_t>(skeleton_.joint_count()), std::nullopt);
  if (kind_ == PointKind::kRobust) {
    person->inlier_views.assign(points->size(), 0);
    for (ViewMatch& match : person->matches) {
      std::fill(match.weights.begin(), match.weights.end(), std::nullopt);
    }
  }
  for (size_t j = 0; j < points->size(); ++j) {
    (*points)[j] = kind_ == PointKind::kRobust ? FromViews(frame, j, person)
                                               : FromInitialPose(frame, j);
  }
}

void JointPoints::CollectViews(const EstimatorFrame& frame, size_t joint_idx,
                               Views which) {
  constexpr double kNearest_m = 0.1;
  views_.clear();
  slots_.clear();
  for (size_t v = 0; v < frame.views.size(); ++v) {
    const FreshView& view = frame.views[v];
    if (joint_idx >= view.joints.size()) continue;
    const Keypoint& joint = view.joints[joint_idx];
    if (!joint.found || !joint.px.allFinite()) continue;
    const bool kept = joint_idx >= view.verdicts.size() ||
                      view.verdicts[joint_idx] == FilterVerdict::kKept;
    if (which == Views::kKeptByFilter && !kept) continue;
    const Camera& camera = cameras_[view.view_idx];
    const double depth_m = camera.Depth(centre_);
    if (!(depth_m > kNearest_m)) continue;
    const double sigma_px =
        PixelSigma(noise_, skeleton_.joint_class(static_cast<int>(joint_idx)),
                   joint.confidence, depth_m, camera.focal_px());
    views_.push_back({&camera, joint.px, sigma_px});
    slots_.push_back(v);
  }
}

std::optional<JointPoint> JointPoints::FromInitialPose(
    const EstimatorFrame& frame, size_t joint_idx) {
  if (!frame.has_initial || joint_idx >= frame.initial.size()) {
    return std::nullopt;
  }
  const Joint3d& joint = frame.initial[joint_idx];
  const bool triangulated =
      frame.triangulated.empty() || frame.triangulated[joint_idx];
  const bool by_two = frame.inlier_views.empty()
                          ? joint.status == JointStatus::kObserved
                          : frame.inlier_views[joint_idx] >= 2;
  if (!triangulated || !by_two || !joint.present() ||
      !joint.position_m.allFinite()) {
    return std::nullopt;
  }
  JointPoint point;
  point.position_m = joint.position_m;
  if (covariances_ == PointCovariances::kOff) return point;
  CollectViews(frame, joint_idx, Views::kKeptByFilter);
  const auto covariance = TriangulationCovariance(views_, point.position_m);
  if (!covariance.has_value()) return std::nullopt;
  point.covariance_m2 = *covariance;
  return point;
}

std::optional<JointPoint> JointPoints::FromViews(const EstimatorFrame& frame,
                                                 size_t joint_idx,
                                                 PersonPose* person) {
  CollectViews(frame, joint_idx, Views::kAll);
  const std::optional<RobustPoint> robust = robust_.Triangulate(views_);
  for (size_t i = 0; i < views_.size() && !person->matches.empty(); ++i) {
    std::vector<std::optional<double>>& weights =
        person->matches[slots_[i]].weights;
    if (joint_idx >= weights.size()) continue;  // weights are not kept
    weights[joint_idx] = robust.has_value() ? robust->weights[i] : 0.0;
  }
  if (!robust.has_value()) return std::nullopt;
  person->inlier_views[joint_idx] = robust->inlier_views;
  return JointPoint{robust->position_m, robust->covariance_m2};
}

}  // namespace kinegraph
