#include "solvers/noise/frame_points.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace kinegraph {
namespace {

// At two, the variance falls with the fourth power of the confidence; no
// detector has needed more.
constexpr std::array<double, 7> kPowers = {0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0};

// Typical correlation time of a detector's errors [s].
constexpr double kMemory = 0.1;

constexpr double kLogGreatest = 2.7725887222397811;  // ln 16

// Maximum of the parabola through the largest entry and its neighbours.
template <size_t N>
double Greatest(const std::array<double, N>& values) {
  const auto at = static_cast<size_t>(
      std::max_element(values.begin(), values.end()) - values.begin());
  if (at == 0 || at + 1 == N) return values[at];
  const double slope = 0.5 * (values[at + 1] - values[at - 1]);
  const double bend = values[at + 1] - 2.0 * values[at] + values[at - 1];
  return bend < 0.0 ? values[at] - 0.5 * slope * slope / bend : values[at];
}

}  // namespace

ConfidenceLearner::ConfidenceLearner(double believed_power,
                                     double frame_rate_hz)
    : believed_power_(believed_power),
      frame_s_(std::max(1.0 / frame_rate_hz, kMemory)),
      // Information relative to independent observations (InformationScale).
      weight_(std::tanh(0.5 * frame_s_ / kMemory)),
      powers_(kPowers.begin(), kPowers.end()) {
  const auto at =
      std::lower_bound(powers_.begin(), powers_.end(), believed_power);
  if (at == powers_.end() || *at != believed_power) {
    powers_.insert(at, believed_power);
  }
  log_likelihood_.resize(powers_.size());
}

bool ConfidenceLearner::BeginFrame(TimeNs time) {
  constexpr double kEarly = 0.5;  // tolerance [ms] for rounded clocks
  if (last_.has_value() &&
      ToSeconds(time - *last_) < frame_s_ - 1e-3 * kEarly) {
    return false;
  }
  last_ = time;
  return true;
}

namespace {

// A view's contribution to the joint's normal equations.
struct LinearView {
  Eigen::Matrix3d square;  // J' J, J by the position [sigmas/m]
  Eigen::Vector3d pull;    // J' r, r the residual
  double residual_square = 0.0;
  double above_mean = 0.0;  // ln confidence minus its mean
};

// Computes, for each scale s, -ln |sigmas| - ln |J' W J| / 2 - d ln s - (t + d)
// / 2 ln(1 + S / (t s^2)), with S the least sum of squares under the power's
// weights, d its degrees of freedom and t the degrees of freedom of the tails.
// False if the views leave a direction undetermined.
template <size_t N>
bool LogLikelihood(const std::vector<LinearView>& views, double added_power,
                   std::array<double, N>* log_likelihood) {
  constexpr double kTails = 4.0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  double square = 0.0;
  double log_sigmas = 0.0;
  for (const LinearView& view : views) {
    const double weight = std::exp(2.0 * added_power * view.above_mean);
    normal += weight * view.square;
    pull += weight * view.pull;
    square += weight * view.residual_square;
    log_sigmas -= 2.0 * added_power * view.above_mean;
  }
  const Eigen::LLT<Eigen::Matrix3d> factor(normal);
  const Eigen::Vector3d diagonal = factor.matrixLLT().diagonal();
  if (factor.info() != Eigen::Success || !(diagonal.minCoeff() > 0.0)) {
    return false;
  }
  square = std::max(0.0, square - pull.dot(factor.solve(pull)));
  const double freedom = 2.0 * static_cast<double>(views.size()) - 3.0;
  const double same = -log_sigmas - diagonal.array().log().sum();
  for (size_t i = 0; i < N; ++i) {
    // 1/16 to 16 in even steps.
    const double log_scale =
        kLogGreatest * (2.0 * static_cast<double>(i) / (N - 1) - 1.0);
    const double tail =
        std::log1p(square * std::exp(-2.0 * log_scale) / kTails);
    (*log_likelihood)[i] =
        same - freedom * log_scale - 0.5 * (kTails + freedom) * tail;
  }
  return std::isfinite(square + same);
}

}  // namespace

void ConfidenceLearner::Add(JointClass joint_class,
                            const std::vector<PixelPoint>& views,
                            const std::vector<double>& log_confidences,
                            const Eigen::Vector3d& point_m,
                            const ConfidenceWeighting& weighting) {
  for (const double log_confidence : log_confidences) {
    ++count_;
    mean_log_ += (log_confidence - mean_log_) / static_cast<double>(count_);
  }
  std::vector<LinearView> linear;
  for (size_t v = 0; v < views.size(); ++v) {
    Matrix23d J;
    const auto image = views[v].camera->Project(point_m, &J);
    if (!image.has_value()) return;
    const Eigen::Vector2d residual = (*image - views[v].px) / views[v].sigma_px;
    J /= views[v].sigma_px;
    linear.push_back({J.transpose() * J, J.transpose() * residual,
                      residual.squaredNorm(), log_confidences[v] - mean_log_});
  }
  std::vector<Scales> by_power(powers_.size());
  for (size_t p = 0; p < powers_.size(); ++p) {
    const double added = powers_[p] - believed_power_ - weighting.added_power;
    if (!LogLikelihood(linear, added, &by_power[p])) return;
  }
  for (size_t p = 0; p < powers_.size(); ++p) {
    Scales& sum = log_likelihood_[p][static_cast<size_t>(joint_class)];
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += weight_ * by_power[p][i];
  }
}

ConfidenceWeighting ConfidenceLearner::Fit() const {
  // Standard deviation of the power between detectors.
  constexpr double kSpread = 0.5;
  ConfidenceWeighting best;
  best.mean_log = mean_log_;
  double greatest = -1e300;
  for (size_t p = 0; p < powers_.size(); ++p) {
    const double added = powers_[p] - believed_power_;
    double posterior = -0.5 * (added / kSpread) * (added / kSpread);
    for (const Scales& of_class : log_likelihood_[p]) {
      posterior += Greatest(of_class);
    }
    const bool is_believed = added == 0.0;
    if (posterior > greatest || (is_believed && posterior >= greatest)) {
      greatest = posterior;
      best.added_power = added;
    }
  }
  return best;
}

namespace {

constexpr double kLastScale = 3.0;  // sigmas

constexpr double kExactM = 1e-6;
constexpr double kRoughM = 1e-3;  // for all stages but the last

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

void FrameTriangulator::LoadViews(const JointChain& chain, size_t k) {
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

// Computes the residuals at the start; false if it cannot be projected into a
// view.
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
  LoadViews(chain, k);
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
  // A view into which the point cannot be projected carries no information
  // about noise.
  for (size_t v = views_.size(); v-- > 0;) {
    if (views_[v].camera->Project(dlt.point_m).has_value()) continue;
    views_.erase(views_.begin() + v);
    log_confidences_.erase(log_confidences_.begin() + v);
  }
  if (views_.size() < 2) return false;
  const auto point = least_squares_.TriangulateFrom(dlt.point_m, views_);
  if (!point.has_value()) return false;
  start_.position_m = point->position_m;
  start_.by_all_views = views_.size() == count;
  start_.found = SetResiduals();
  return start_.found;
}

bool FrameTriangulator::LoadAgain(const JointChain& chain, size_t k,
                                  const Start& start) {
  if (!start.found) return false;
  if (!start.by_all_views) return Load(chain, k);
  start_ = start;
  LoadViews(chain, k);
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
  return FramePoint{point->position_m, point->covariance_m2 / correction_};
}

}  // namespace kinegraph
