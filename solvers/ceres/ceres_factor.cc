#include "solvers/ceres/ceres_factor.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace kinegraph {

CeresPersonPrior::CeresPersonPrior(const PersonPrior* prior) : prior_(prior) {
  set_num_residuals(static_cast<int>(prior->A.rows()));
  mutable_parameter_block_sizes()->assign(prior->x0.size() / kStateSize,
                                          kStateSize);
}

bool CeresPersonPrior::Evaluate(double const* const* parameters,
                                double* residuals, double** jacobians) const {
  const size_t joint_count = parameter_block_sizes().size();
  PersonStates states(joint_count);
  for (size_t j = 0; j < joint_count; ++j) {
    states[j].push_back(Eigen::Map<const State>(parameters[j]));
  }
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) =
      prior_->Residual(states);
  if (jacobians == nullptr) return true;
  for (size_t j = 0; j < joint_count; ++j) {
    if (jacobians[j] == nullptr) continue;
    Eigen::Map<
        Eigen::Matrix<double, Eigen::Dynamic, kStateSize, Eigen::RowMajor>>(
        jacobians[j], num_residuals(), kStateSize) =
        prior_->A.middleCols<kStateSize>(kStateSize *
                                         static_cast<Eigen::Index>(j));
  }
  return true;
}

namespace {

ceres::LossFunction* MakePlain(LossKind kind, double scale) {
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

}  // namespace

void GemanMcClureLoss::Evaluate(double s, double rho[3]) const {
  const LossValue value = EvaluateLoss(LossKind::kGemanMcClure, scale_, s);
  rho[0] = value.rho;
  rho[1] = value.first;
  rho[2] = value.second;
}

ceres::LossFunction* MakeCeresLoss(LossKind kind, double scale,
                                   double information) {
  ceres::LossFunction* plain = MakePlain(kind, scale);
  if (information == 1.0) return plain;
  return new ceres::ScaledLoss(plain, information, ceres::TAKE_OWNERSHIP);
}

namespace {

// Factors of a robust residual: of r itself, and of J across and along r.
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

}  // namespace

ViewBundle::ViewBundle(std::vector<View> views) : views_(std::move(views)) {
  set_num_residuals(CameraReprojection::kResiduals *
                    static_cast<int>(views_.size()));
  mutable_parameter_block_sizes()->assign(1, kStateSize);
}

bool ViewBundle::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const double* const states[] = {parameters[0]};
  double* out = jacobians == nullptr ? nullptr : jacobians[0];
  constexpr std::ptrdiff_t kNumbers = std::ptrdiff_t{2} * kStateSize;
  for (const View& view : views_) {
    double r[2];
    PointJacobian<2, double> by_state;
    if (!view.factor.Evaluate(states, r,
                              out == nullptr ? nullptr : &by_state)) {
      return false;
    }
    const double s = r[0] * r[0] + r[1] * r[1];
    const Roots roots = RootsOf(view.robustness, s);
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
