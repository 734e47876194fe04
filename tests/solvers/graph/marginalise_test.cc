#include "solvers/graph/marginalise.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>

#include "core/base/random.h"

namespace kinegraph {
namespace {

// The prior that remains when the first kDropped variables of the rows [J r]
// are eliminated.
template <int kColumns, int kDropped>
SquareRootPrior<kColumns - kDropped> Marginalise(const Eigen::MatrixXd& rows) {
  RowTriangle<kColumns> triangle;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    typename RowTriangle<kColumns>::Row row;
    for (int column = 0; column <= kColumns; ++column) {
      row[column] = rows(i, column);
    }
    triangle.Add(row);
  }
  return triangle.template Drop<kDropped>();
}

TEST(Marginalise, HandWorkedPair) {
  // The measurements x = 3 +- 1 and y - x = 4 +- 1, linearised at zero, imply
  // y = 7 with variance 2.
  Eigen::MatrixXd rows(2, 3);
  rows << 1.0, 0.0, -3.0, -1.0, 1.0, -4.0;
  const auto prior = Marginalise<2, 1>(rows);
  EXPECT_NEAR(prior.A(0, 0) * prior.A(0, 0), 0.5, 1e-14);
  EXPECT_NEAR(-prior.b(0) / prior.A(0, 0), 7.0, 1e-14);
}

template <int kDropped, int kKept>
void ExpectMinimumAndCovariance(Random* random) {
  constexpr int kColumns = kDropped + kKept;
  const int count = kColumns + static_cast<int>(random->Index(10));
  Eigen::MatrixXd rows(count, kColumns + 1);
  for (Eigen::Index i = 0; i < rows.size(); ++i) {
    rows.data()[i] = random->Normal();
  }
  const Eigen::MatrixXd jacobian = rows.leftCols(kColumns);
  const Eigen::VectorXd minimum =
      -jacobian.colPivHouseholderQr().solve(rows.col(kColumns));
  const Eigen::MatrixXd covariance =
      (jacobian.transpose() * jacobian).inverse();
  const auto prior = Marginalise<kColumns, kDropped>(rows);
  const Eigen::VectorXd own = -prior.A.lu().solve(prior.b);
  const Eigen::MatrixXd own_covariance =
      (prior.A.transpose() * prior.A).inverse();
  // Condition numbers of small Gaussian matrices reach 1e3, squared in the
  // covariance: 1e-16 * 1e6, with a margin.
  EXPECT_LT((own - minimum.tail(kKept)).norm(), 1e-8 * (1.0 + own.norm()));
  EXPECT_LT(
      (own_covariance - covariance.bottomRightCorner(kKept, kKept)).norm(),
      1e-8 * own_covariance.norm());
}

TEST(Marginalise, KeepsMinimumAndCovarianceOfRandomSystems) {
  Random random(23);
  for (int trial = 0; trial < 5; ++trial) {
    ExpectMinimumAndCovariance<1, 1>(&random);
    ExpectMinimumAndCovariance<1, 5>(&random);
    ExpectMinimumAndCovariance<4, 2>(&random);
    ExpectMinimumAndCovariance<6, 6>(&random);
  }
}

TEST(Marginalise, TrailingZerosOfRowsMayBeOmitted) {
  Random random(29);
  RowTriangle<4> whole;
  RowTriangle<4> cut;
  for (int i = 0; i < 9; ++i) {
    RowTriangle<4>::Row row{};
    const int end = i < 5 ? 2 : 4;
    for (int column = 0; column < end; ++column) row[column] = random.Normal();
    row.back() = random.Normal();
    whole.Add(row);
    cut.Add(row, end);
  }
  const auto a = whole.Drop<2>();
  const auto b = cut.Drop<2>();
  // Signs of rows are arbitrary, so products are compared. A unit of rounding
  // in each entry of nine rows of five numbers near one, 45 * 2.2e-16 = 1e-14,
  // is a tenth of the tolerance.
  EXPECT_LT((a.A.transpose() * a.A - b.A.transpose() * b.A).norm(), 1e-13);
  EXPECT_LT((a.A.transpose() * a.b - b.A.transpose() * b.b).norm(), 1e-13);
}

TEST(Marginalise, RowsMayExceedTheBuffer) {
  Random random(31);
  RowTriangle<3> triangle;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 200; ++i) {
    Eigen::Vector3d row(random.Normal(), random.Normal(), random.Normal());
    information += row * row.transpose();
    triangle.Add({row[0], row[1], row[2], 0.0});
  }
  const auto prior = triangle.Drop<1>();
  const Eigen::Matrix2d kept = information.bottomRightCorner<2, 2>() -
                               information.bottomLeftCorner<2, 1>() *
                                   information.topRightCorner<1, 2>() /
                                   information(0, 0);
  // Rounding of sums of 200 products.
  EXPECT_LT((prior.A.transpose() * prior.A - kept).norm(), 1e-11);
}

TEST(Marginalise, AddsNoInformationOnAnUnmeasuredVariable) {
  // Only the dropped variable is measured.
  Eigen::MatrixXd rows(2, 3);
  rows << 1.0, 0.0, 1.0, 0.0, 0.0, 0.0;
  const auto prior = Marginalise<2, 1>(rows);
  EXPECT_EQ(prior.A(0, 0), 0.0);
  EXPECT_EQ(prior.b(0), 0.0);
}

}  // namespace
}  // namespace kinegraph
