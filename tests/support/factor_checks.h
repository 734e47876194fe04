// Checks that the Jacobians of every factor (a ceres::CostFunction) must pass.
#ifndef KINEGRAPH_TESTS_SUPPORT_FACTOR_CHECKS_H_
#define KINEGRAPH_TESTS_SUPPORT_FACTOR_CHECKS_H_

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace kinegraph::testing {

using RowMajorMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Evaluation {
  bool ok = false;
  Eigen::VectorXd residuals;
  std::vector<RowMajorMatrix> jacobians;  // one per block
};

using Blocks = std::vector<Eigen::VectorXd>;

inline std::vector<const double*> Pointers(const Blocks& blocks) {
  std::vector<const double*> pointers;
  for (const Eigen::VectorXd& block : blocks) pointers.push_back(block.data());
  return pointers;
}

inline Evaluation Evaluate(const ceres::CostFunction& factor,
                           const Blocks& blocks) {
  Evaluation result;
  result.residuals.setZero(factor.num_residuals());
  std::vector<double*> pointers;
  for (const int32_t size : factor.parameter_block_sizes()) {
    // NaN reveals an entry that was never written.
    result.jacobians.emplace_back(
        RowMajorMatrix::Constant(factor.num_residuals(), size, NAN));
  }
  for (RowMajorMatrix& jacobian : result.jacobians) {
    pointers.push_back(jacobian.data());
  }
  result.ok = factor.Evaluate(Pointers(blocks).data(), result.residuals.data(),
                              pointers.data());
  return result;
}

// Largest difference of two matrices, divided by their largest entry (or by 1).
inline double RelativeError(const Eigen::MatrixXd& a,
                            const Eigen::MatrixXd& b) {
  const double scale =
      std::max({1.0, a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()});
  const double difference = (a - b).cwiseAbs().maxCoeff();
  return std::isfinite(difference) ? difference / scale : INFINITY;
}

// Expects central differences to agree. Their truncation error is of order
// step^2 and their rounding error of order epsilon / step: with a step of 1e-6
// together some 2e-10 of the residuals' scale, far below the tolerance of 1e-6.
inline void ExpectNumericJacobians(const ceres::CostFunction& factor,
                                   const Blocks& blocks) {
  const Evaluation analytic = Evaluate(factor, blocks);
  ASSERT_TRUE(analytic.ok);
  constexpr double kStep = 1e-6;
  for (size_t block = 0; block < blocks.size(); ++block) {
    RowMajorMatrix numeric = analytic.jacobians[block];
    for (Eigen::Index i = 0; i < blocks[block].size(); ++i) {
      Blocks high = blocks;
      Blocks low = blocks;
      high[block](i) += kStep;
      low[block](i) -= kStep;
      numeric.col(i) =
          (Evaluate(factor, high).residuals - Evaluate(factor, low).residuals) /
          (2.0 * kStep);
    }
    EXPECT_LT(RelativeError(analytic.jacobians[block], numeric), 1e-6)
        << "block " << block << "\nanalytic\n"
        << analytic.jacobians[block] << "\nnumeric\n"
        << numeric;
  }
}

// `twin` is the same factor, differentiated automatically. Expects residuals
// and Jacobians of both to be equal up to rounding.
inline void ExpectSameAsTwin(const ceres::CostFunction& factor,
                             const ceres::CostFunction& twin,
                             const Blocks& blocks) {
  const Evaluation a = Evaluate(factor, blocks);
  const Evaluation b = Evaluate(twin, blocks);
  ASSERT_TRUE(a.ok && b.ok);
  EXPECT_LT(RelativeError(a.residuals, b.residuals), 1e-11);
  for (size_t block = 0; block < blocks.size(); ++block) {
    EXPECT_LT(RelativeError(a.jacobians[block], b.jacobians[block]), 1e-11)
        << "block " << block;
  }
}

// Expects the same residuals and Jacobians if Ceres requests no Jacobians, or
// any subset of them by passing null pointers for the others.
inline void ExpectAbsentJacobiansAreRespected(const ceres::CostFunction& factor,
                                              const Blocks& blocks) {
  const Evaluation full = Evaluate(factor, blocks);
  Eigen::VectorXd residuals(factor.num_residuals());
  residuals.setConstant(NAN);
  ASSERT_TRUE(
      factor.Evaluate(Pointers(blocks).data(), residuals.data(), nullptr));
  EXPECT_EQ(residuals, full.residuals);
  for (unsigned subset = 0; subset < (1u << blocks.size()); ++subset) {
    std::vector<RowMajorMatrix> jacobians = full.jacobians;
    std::vector<double*> pointers(blocks.size(), nullptr);
    for (size_t block = 0; block < blocks.size(); ++block) {
      jacobians[block].setConstant(NAN);
      if ((subset >> block) & 1u) pointers[block] = jacobians[block].data();
    }
    residuals.setConstant(NAN);
    ASSERT_TRUE(factor.Evaluate(Pointers(blocks).data(), residuals.data(),
                                pointers.data()));
    EXPECT_EQ(residuals, full.residuals);
    for (size_t block = 0; block < blocks.size(); ++block) {
      if (pointers[block] != nullptr) {
        EXPECT_EQ(jacobians[block], full.jacobians[block]);
      }
    }
  }
}

inline void ExpectSoundJacobians(const ceres::CostFunction& factor,
                                 const ceres::CostFunction& twin,
                                 const Blocks& blocks) {
  ExpectNumericJacobians(factor, blocks);
  ExpectSameAsTwin(factor, twin, blocks);
  ExpectAbsentJacobiansAreRespected(factor, blocks);
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_FACTOR_CHECKS_H_
