#include "solvers/graph/marginalise.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>

#include "core/base/random.h"

namespace kinegraph {
namespace {

TEST(Marginalise, HandWorkedPair) {
  // x ~ 3 +- 1, y - x ~ 4 +- 1 at x = y = 0: y ~ 7 with variance 2.
  Eigen::MatrixXd jacobian(2, 2);
  jacobian << 1.0, 0.0, -1.0, 1.0;
  const Eigen::Vector2d residual(-3.0, -4.0);
  const SquareRootPrior prior = Marginalise(jacobian, residual, 1);
  ASSERT_EQ(prior.A.size(), 1);
  EXPECT_NEAR(prior.A(0, 0) * prior.A(0, 0), 0.5, 1e-14);
  EXPECT_NEAR(-prior.b(0) / prior.A(0, 0), 7.0, 1e-14);
}

TEST(Marginalise, KeepsMinimumAndCovarianceOfRandomSystems) {
  Random random(23);
  for (int trial = 0; trial < 20; ++trial) {
    const int dropped = 1 + static_cast<int>(random.Index(6));
    const int kept = 1 + static_cast<int>(random.Index(6));
    const int rows = dropped + kept + static_cast<int>(random.Index(10));
    Eigen::MatrixXd jacobian(rows, dropped + kept);
    Eigen::VectorXd residual(rows);
    for (Eigen::Index i = 0; i < jacobian.size(); ++i) {
      jacobian.data()[i] = random.Normal();
    }
    for (int i = 0; i < rows; ++i) residual(i) = random.Normal();
    const Eigen::VectorXd minimum =
        -jacobian.colPivHouseholderQr().solve(residual);
    const Eigen::MatrixXd covariance =
        (jacobian.transpose() * jacobian).inverse();
    const SquareRootPrior prior = Marginalise(jacobian, residual, dropped);
    const Eigen::VectorXd own = -prior.A.lu().solve(prior.b);
    const Eigen::MatrixXd own_covariance =
        (prior.A.transpose() * prior.A).inverse();
    // Condition numbers of small Gaussian matrices reach 1e3, squared in the
    // covariance: 1e-16 * 1e6, with room.
    EXPECT_LT((own - minimum.tail(kept)).norm(), 1e-8 * (1.0 + own.norm()));
    EXPECT_LT(
        (own_covariance - covariance.bottomRightCorner(kept, kept)).norm(),
        1e-8 * own_covariance.norm());
  }
}

TEST(Marginalise, WhatIsUnknownStaysUnknown) {
  // Only the dropped variable is measured: nothing is said of the kept one.
  Eigen::MatrixXd jacobian(2, 2);
  jacobian << 1.0, 0.0, 0.0, 0.0;
  const SquareRootPrior prior =
      Marginalise(jacobian, Eigen::Vector2d(1.0, 0.0), 1);
  EXPECT_EQ(prior.A(0, 0), 0.0);
  EXPECT_EQ(prior.b(0), 0.0);
}

}  // namespace
}  // namespace kinegraph
