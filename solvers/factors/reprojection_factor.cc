#include "solvers/factors/reprojection_factor.h"

#include <optional>

namespace kinegraph {

ReprojectionFactor::ReprojectionFactor(const Camera* camera,
                                       const Eigen::Vector2d& px,
                                       double sigma_px, double offset_s)
    : camera_(camera),
      px_(px),
      inverse_sigma_(1.0 / sigma_px),
      offset_s_(offset_s) {}

bool ReprojectionFactor::Evaluate(double const* const* parameters,
                                  double* residuals, double** jacobians) const {
  const Eigen::Map<const State> state(parameters[0]);
  const bool wants_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
  Matrix23d by_point;
  const std::optional<Eigen::Vector2d> image =
      camera_->Project(state.head<3>() + offset_s_ * state.tail<3>(),
                       wants_jacobian ? &by_point : nullptr);
  if (!image.has_value()) return false;
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  residual = inverse_sigma_ * (*image - px_);
  if (wants_jacobian) {
    Eigen::Map<Eigen::Matrix<double, 2, kStateSize, Eigen::RowMajor>> jacobian(
        jacobians[0]);
    jacobian.leftCols<3>() = inverse_sigma_ * by_point;
    jacobian.rightCols<3>() = (inverse_sigma_ * offset_s_) * by_point;
  }
  return true;
}

}  // namespace kinegraph
