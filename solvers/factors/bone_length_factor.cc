#include "solvers/factors/bone_length_factor.h"

namespace kinegraph {

bool BoneLengthFactor::Evaluate(double const* const* parameters,
                                double* residuals, double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> a(parameters[0]);
  const Eigen::Map<const Eigen::Vector3d> b(parameters[1]);
  const Eigen::Vector3d bone = a - b;
  const double length = bone.norm();
  residuals[0] = per_m_ * (length - length_m_);
  if (jacobians == nullptr) return true;
  constexpr double kCoincident = 1e-9;  // m
  const Eigen::Vector3d by_a = length > kCoincident
                                   ? Eigen::Vector3d(per_m_ / length * bone)
                                   : Eigen::Vector3d::Zero();
  for (int block = 0; block < 2; ++block) {
    if (jacobians[block] == nullptr) continue;
    Eigen::Map<State> jacobian(jacobians[block]);
    jacobian.head<3>() = block == 0 ? by_a : Eigen::Vector3d(-by_a);
    jacobian.tail<3>().setZero();
  }
  return true;
}

}  // namespace kinegraph
