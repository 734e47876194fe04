#include "solvers/noise/frame_points.h"

#include <utility>

namespace kinegraph {
namespace {

constexpr double kLastScale = 3.0;  // sigmas

constexpr double kExactM = 1e-6;
constexpr double kRoughM = 1e-3;  // of a stage that another one follows

RobustTriangulator Stage(LossKind loss, double scale, double last_step_m) {
  RobustTriangulationOptions options;
  options.loss = loss;
  options.loss_scale = scale;
  options.last_step_m = last_step_m;
  return RobustTriangulator(options);
}

}  // namespace

FrameTriangulator::FrameTriangulator(const CameraRig& cameras)
    : cameras_(cameras),
      least_squares_(Stage(LossKind::kNone, 1.0, kExactM)),
      stages_({Stage(LossKind::kHuber, 1.5, kRoughM),
               Stage(LossKind::kGemanMcClure, 2.0 * kLastScale, kRoughM),
               Stage(LossKind::kGemanMcClure, kLastScale, kExactM)}),
      correction_(InformationCorrection(LossKind::kGemanMcClure, kLastScale)) {}

void FrameTriangulator::RecordingViews(const JointChain& chain, size_t k) {
  views_.clear();
  log_confidences_.clear();
  for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
    const PixelMeasurement& measurement = chain.measurements[m];
    views_.push_back({measurement.camera,
                      measurement.px - measurement.bias_px.cast<double>(),
                      measurement.model_sigma_px *
                          weighting_.SigmaFactor(measurement.log_confidence)});
    log_confidences_.push_back(measurement.log_confidence);
  }
}

// At the start; false where a view does not see it.
bool FrameTriangulator::SetResiduals() {
  residuals_.views.clear();
  residuals_.square = 0.0;
  for (const PixelPoint& view : views_) {
    const auto image = view.camera->Project(start_.position_m);
    if (!image.has_value()) return false;
    TriangulationResiduals::View& seen = residuals_.views.emplace_back();
    seen.view_idx = static_cast<int>(view.camera - cameras_.data());
    seen.residual = (*image - view.px) / view.sigma_px;
    residuals_.square += seen.residual.squaredNorm();
  }
  return true;
}

bool FrameTriangulator::Load(const JointChain& chain, size_t k) {
  start_ = {};
  RecordingViews(chain, k);
  const size_t count = views_.size();
  ideal_.clear();
  size_t taken = 0;
  for (size_t v = 0; v < count; ++v) {
    const PixelPoint view = views_[v];
    const auto ideal = view.camera->Undistort(view.px);
    if (!ideal.has_value()) continue;
    log_confidences_[taken] = log_confidences_[v];
    views_[taken++] = view;
    ideal_.push_back({view.camera, *ideal, 1.0 / view.sigma_px});
  }
  views_.resize(taken);
  log_confidences_.resize(taken);
  if (views_.size() < 2) return false;
  TriangulationOptions anywhere;
  anywhere.require_in_front = false;
  const TriangulationResult dlt = TriangulateDlt(ideal_, anywhere);
  if (!dlt.ok()) return false;
  // A view behind which the point would stand says nothing of noise.
  for (size_t v = views_.size(); v-- > 0;) {
    if (views_[v].camera->Project(dlt.point_m).has_value()) continue;
    views_.erase(views_.begin() + static_cast<std::ptrdiff_t>(v));
    log_confidences_.erase(log_confidences_.begin() +
                           static_cast<std::ptrdiff_t>(v));
  }
  if (views_.size() < 2) return false;
  const auto point = least_squares_.TriangulateFrom(dlt.point_m, views_);
  if (!point.has_value()) return false;
  start_.position_m = point->position_m;
  start_.by_all_views = views_.size() == count;
  start_.found = SetResiduals();
  return start_.found;
}

FrameTriangulator::Start FrameTriangulator::start() const { return start_; }

bool FrameTriangulator::LoadAgain(const JointChain& chain, size_t k,
                                  const Start& start) {
  if (!start.found) return false;
  if (!start.by_all_views) return Load(chain, k);
  start_ = start;
  RecordingViews(chain, k);
  return SetResiduals();
}

std::optional<FramePoint> FrameTriangulator::Robust(double scale) {
  scaled_ = views_;
  for (PixelPoint& view : scaled_) view.sigma_px *= scale;
  std::optional<RobustPoint> point;
  Eigen::Vector3d start_m = start_.position_m;
  for (const RobustTriangulator& stage : stages_) {
    point = stage.TriangulateFrom(start_m, scaled_);
    if (!point.has_value()) return std::nullopt;
    start_m = point->position_m;
  }
  const auto views = static_cast<int>(scaled_.size());
  const int inliers = point->inlier_views;
  const bool agreed =
      views == 2 ? inliers == 2 : inliers >= 3 && 2 * inliers > views;
  if (!agreed) return std::nullopt;
  return FramePoint{point->position_m, point->covariance_m2 / correction_,
                    std::move(point->weights)};
}

}  // namespace kinegraph
