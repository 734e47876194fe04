#include "core/base/dense_lanes.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>

#include "core/base/instruction_set.h"
#include "core/base/random.h"

namespace kinegraph {
namespace {

// Error bound of a backward-stable elimination of n columns: n rounding errors
// times the condition number, with a safety factor of four.
double Tolerance(const Eigen::MatrixXd& pivot) {
  const double norm = pivot.norm() * pivot.inverse().norm();
  return 4.0 * static_cast<double>(pivot.rows()) * 1.1e-16 * norm;
}

struct Blocks {
  int size = 0;
  int padded = 0;
  int block = 0;
  Eigen::MatrixXd pivot, coupling, next;

  bool Run() {
    return EliminateDense(
        {padded, block, pivot.data(), coupling.data(), next.data()});
  }
};

Eigen::MatrixXd RandomSquare(int size, Random* random) {
  Eigen::MatrixXd square(size, size);
  for (Eigen::Index i = 0; i < square.size(); ++i) {
    square.data()[i] = random->Normal();
  }
  return square;
}

// The coupling is block-diagonal with blocks of size `block`, or dense if this
// is 0.
Blocks MakeBlocks(int size, int block, Random* random) {
  Blocks blocks;
  blocks.size = size;
  blocks.padded = (size + 7) / 8 * 8;
  blocks.block = block;
  blocks.pivot = Eigen::MatrixXd::Identity(blocks.padded, blocks.padded);
  const Eigen::MatrixXd root = RandomSquare(size, random);
  blocks.pivot.topLeftCorner(size, size) +=
      root * root.transpose() / static_cast<double>(size);
  blocks.coupling = Eigen::MatrixXd::Zero(blocks.padded, blocks.padded);
  const int step = block == 0 ? size : block;
  for (int at = 0; at < size; at += step) {
    blocks.coupling.block(at, at, step, step) = RandomSquare(step, random);
  }
  blocks.next = Eigen::MatrixXd::Zero(blocks.padded, blocks.padded);
  blocks.next.topLeftCorner(size, size) = RandomSquare(size, random);
  return blocks;
}

class DenseLanesTest : public ::testing::TestWithParam<InstructionSet> {
 protected:
  // Falls back to the best set that this machine supports.
  void SetUp() override { UseInstructionSet(GetParam()); }
  void TearDown() override { UseInstructionSet(BestInstructionSet()); }
};

TEST_P(DenseLanesTest, FactorAndSchurComplementAreAccurate) {
  Random random(3);
  for (const int block : {0, 6}) {
    for (const int size : {6, 12, 42, 84, 102, 150}) {
      const Blocks before = MakeBlocks(size, block, &random);
      Blocks after = before;
      ASSERT_TRUE(after.Run());
      const double tolerance = Tolerance(before.pivot);
      const Eigen::MatrixXd lower = after.pivot.triangularView<Eigen::Lower>();
      EXPECT_LT((lower * lower.transpose() - before.pivot).norm(), tolerance)
          << size;
      EXPECT_LT((after.coupling * lower.transpose() - before.coupling).norm(),
                tolerance * before.coupling.norm())
          << size;
      const Eigen::MatrixXd expected =
          before.next - before.coupling * before.pivot.llt().solve(
                                              before.coupling.transpose());
      const Eigen::MatrixXd difference =
          (after.next - expected).triangularView<Eigen::Lower>();
      EXPECT_LT(difference.norm(), tolerance * expected.norm()) << size;
    }
  }
}

TEST_P(DenseLanesTest, IsBitIdenticalToBaseline) {
  Random random(4);
  const Blocks before = MakeBlocks(102, 6, &random);
  Blocks here = before;
  ASSERT_TRUE(here.Run());
  UseInstructionSet(InstructionSet::kBaseline);
  Blocks baseline = before;
  ASSERT_TRUE(baseline.Run());
  for (int column = 0; column < before.padded; ++column) {
    for (int row = column; row < before.padded; ++row) {
      ASSERT_EQ(here.pivot(row, column), baseline.pivot(row, column));
      ASSERT_EQ(here.next(row, column), baseline.next(row, column));
    }
  }
  EXPECT_EQ(here.coupling, baseline.coupling);
}

TEST_P(DenseLanesTest, RefusesIndefiniteAndNaNPivots) {
  Random random(5);
  for (const int bad : {0, 3, 50, 101}) {
    Blocks blocks = MakeBlocks(102, 6, &random);
    blocks.pivot(bad, bad) = -1.0;
    EXPECT_FALSE(blocks.Run()) << bad;
    blocks = MakeBlocks(102, 6, &random);
    blocks.pivot(bad, bad) = NAN;
    EXPECT_FALSE(blocks.Run()) << bad;
  }
}

TEST_P(DenseLanesTest, IgnoresValuesAboveTheDiagonal) {
  Random random(6);
  Blocks clean = MakeBlocks(42, 6, &random);
  Blocks dirty = clean;
  for (int column = 0; column < clean.padded; ++column) {
    for (int row = 0; row < column; ++row) dirty.pivot(row, column) = NAN;
  }
  ASSERT_TRUE(clean.Run());
  ASSERT_TRUE(dirty.Run());
  EXPECT_EQ(clean.coupling, dirty.coupling);
}

INSTANTIATE_TEST_SUITE_P(Sets, DenseLanesTest,
                         ::testing::Values(InstructionSet::kBaseline,
                                           InstructionSet::kAvx2,
                                           InstructionSet::kAvx512));

}  // namespace
}  // namespace kinegraph
