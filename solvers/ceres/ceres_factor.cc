#include "solvers/ceres/ceres_factor.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kinegraph {

CeresPersonPrior::CeresPersonPrior(size_t joint_count) {
  set_num_residuals(kStateSize * static_cast<int>(joint_count));
  mutable_parameter_block_sizes()->assign(joint_count, kStateSize);
}

bool CeresPersonPrior::Evaluate(double const* const* parameters,
                                double* residuals, double** jacobians) const {
  const size_t joint_count = parameter_block_sizes().size();
  Eigen::Map<Eigen::VectorXd> residual(residuals, num_residuals());
  residual = prior_->b;
  for (size_t j = 0; j < joint_count; ++j) {
    const auto column = kStateSize * static_cast<Eigen::Index>(j);
    const auto by_state = prior_->A.middleCols<kStateSize>(column);
    const State away = Eigen::Map<const State>(parameters[j]) -
                       prior_->x0.segment<kStateSize>(column);
    residual.noalias() += by_state * away;
    if (jacobians == nullptr || jacobians[j] == nullptr) continue;
    Eigen::Map<
        Eigen::Matrix<double, Eigen::Dynamic, kStateSize, Eigen::RowMajor>>(
        jacobians[j], num_residuals(), kStateSize) = by_state;
  }
  return true;
}

namespace {

// Geman and McClure (1985): rho(s) = c^2 s / (c^2 + s). Ceres 2.1 has none.
class GemanMcClureLoss final : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double scale) : scale_(scale) {}
  void Evaluate(double s, double rho[3]) const override {
    const LossValue value = EvaluateLoss(LossKind::kGemanMcClure, scale_, s);
    rho[0] = value.rho;
    rho[1] = value.first;
    rho[2] = value.second;
  }

 private:
  double scale_;
};

}  // namespace

ceres::LossFunction* MakeCeresLoss(LossKind kind, double scale) {
  switch (kind) {
    case LossKind::kNone:
      break;
    case LossKind::kHuber:
      return new ceres::HuberLoss(scale);
    case LossKind::kCauchy:
      return new ceres::CauchyLoss(scale);
    case LossKind::kGemanMcClure:
      return new GemanMcClureLoss(scale);
    case LossKind::kTukey:
      return new ceres::TukeyLoss(scale);
  }
  return nullptr;
}

namespace {

// Scale factors that robustify a block: of its residual r, and of the
// components of its Jacobian across (perpendicular to) and along r. Compare
// ceres::internal::Corrector.
struct Roots {
  double residual = 1.0;
  double across = 1.0;
  double along = 1.0;
};

Roots RootsOf(const Robustness& robustness, double s) {
  const double root = std::sqrt(robustness.information);
  constexpr double kTiny = 1e-12;  // all losses are s + O(s^2)
  if (s < kTiny) return {root, root, root};
  const LossValue loss = robustness.Evaluate(s);
  const double share = std::sqrt(loss.rho / s);
  return {root * share, root * std::sqrt(loss.first),
          root * loss.first / share};
}

constexpr int kCentreRows = BodyCentre<double>::kResiduals;

}  // namespace

ViewBundle::ViewBundle() {
  set_num_residuals(kCentreRows);
  mutable_parameter_block_sizes()->assign(1, kStateSize);
}

void ViewBundle::Set(const JointChain& chain, size_t k,
                     const PersonCentre& centre, const SolveStage* stage) {
  begin_ = chain.measurements.data() + chain.first[k];
  end_ = chain.measurements.data() + chain.first[k + 1];
  centre_ = {centre.position_m.data(), centre.per_sigma};
  stage_ = stage;
  const auto count = std::count_if(
      begin_, end_,
      [](const PixelMeasurement& measurement) { return !measurement.gated; });
  set_num_residuals(kCentreRows +
                    CameraReprojection::kResiduals * static_cast<int>(count));
}

bool ViewBundle::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const double* const states[] = {parameters[0]};
  double* out = jacobians == nullptr ? nullptr : jacobians[0];
  BodyCentre<double>::Jacobian by_position;
  centre_.Evaluate(states, residuals, &by_position);
  residuals += kCentreRows;
  for (int row = 0; out != nullptr && row < kCentreRows; ++row) {
    for (int i = 0; i < kStateSize; ++i) *out++ = by_position(row, i);
  }
  constexpr std::ptrdiff_t kNumbers = std::ptrdiff_t{2} * kStateSize;
  for (const PixelMeasurement* m = begin_; m != end_; ++m) {
    if (m->gated) continue;
    double r[2];
    PointJacobian<2, double> by_state;
    if (!ReprojectionOf(*m).Evaluate(states, r,
                                     out == nullptr ? nullptr : &by_state)) {
      return false;
    }
    const double s = r[0] * r[0] + r[1] * r[1];
    const Roots roots = RootsOf(
        {stage_->loss, stage_->scale, m->information, /*measurement=*/-1}, s);
    *residuals++ = roots.residual * r[0];
    *residuals++ = roots.residual * r[1];
    if (out == nullptr) continue;
    const double turn = s > 0.0 ? (roots.along - roots.across) / s : 0.0;
    for (int i = 0; i < kStateSize; ++i) {
      const double inward = r[0] * by_state(0, i) + r[1] * by_state(1, i);
      out[i] = roots.across * by_state(0, i) + turn * inward * r[0];
      out[kStateSize + i] =
          roots.across * by_state(1, i) + turn * inward * r[1];
    }
    out += kNumbers;
  }
  return true;
}

}  // namespace kinegraph
