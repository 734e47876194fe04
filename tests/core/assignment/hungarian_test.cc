#include "core/assignment/hungarian.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "core/base/random.h"

namespace kinegraph {
namespace {

struct Problem {
  int rows;
  int cols;
  std::vector<double> cost;
};

double Total(const Problem& problem, const std::vector<int>& col_of_row) {
  double total = 0.0;
  for (int r = 0; r < problem.rows; ++r) {
    if (col_of_row[r] >= 0) {
      total += problem.cost[r * problem.cols + col_of_row[r]];
    }
  }
  return total;
}

// The least total over all permutations of the larger side.
double BruteForceMinimum(const Problem& problem) {
  const int n = std::min(problem.rows, problem.cols);
  const int m = std::max(problem.rows, problem.cols);
  std::vector<int> order(m);
  std::iota(order.begin(), order.end(), 0);
  double best = std::numeric_limits<double>::infinity();
  do {
    double total = 0.0;
    for (int i = 0; i < n; ++i) {
      const int r = problem.rows <= problem.cols ? i : order[i];
      const int c = problem.rows <= problem.cols ? order[i] : i;
      total += problem.cost[r * problem.cols + c];
    }
    best = std::min(best, total);
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

void ExpectOneToOne(const Problem& problem, const std::vector<int>& result) {
  std::vector<int> used(problem.cols, 0);
  int assigned = 0;
  for (const int c : result) {
    if (c < 0) continue;
    ASSERT_LT(c, problem.cols);
    EXPECT_EQ(used[c]++, 0) << "column " << c << " is assigned twice";
    ++assigned;
  }
  EXPECT_EQ(assigned, std::min(problem.rows, problem.cols));
}

TEST(HungarianTest, EqualsBruteForceOnRandomRectangles) {
  Random random(7);
  HungarianSolver solver;
  std::vector<int> result;
  for (int round = 0; round < 400; ++round) {
    Problem problem{static_cast<int>(1 + random.Index(6)),
                    static_cast<int>(1 + random.Index(6)),
                    {}};
    for (int i = 0; i < problem.rows * problem.cols; ++i) {
      // Half of the rounds have many ties and exact arithmetic.
      problem.cost.push_back(round % 2 == 0
                                 ? static_cast<double>(random.Index(4))
                                 : random.Uniform(-5.0, 5.0));
    }
    solver.Minimise(problem.cost, problem.rows, problem.cols, &result);
    ExpectOneToOne(problem, result);
    // Sums of at most six numbers below 5: rounding stays below 1e-13.
    EXPECT_NEAR(Total(problem, result), BruteForceMinimum(problem), 1e-13);

    Problem negative = problem;
    for (double& c : negative.cost) c = -c;
    solver.Maximise(problem.cost, problem.rows, problem.cols, &result);
    EXPECT_NEAR(Total(negative, result), BruteForceMinimum(negative), 1e-13);
  }
}

TEST(HungarianTest, SolvesSmallAndEmptyProblemsAndRejectsInvalidCosts) {
  HungarianSolver solver;
  std::vector<int> result = {5};
  // The diagonal costs 1 + 3 = 4; crossing costs 2 + 0 = 2.
  solver.Minimise(std::vector<double>{1, 2, 0, 3}, 2, 2, &result);
  EXPECT_EQ(result, (std::vector<int>{1, 0}));
  // Ties go to the lowest indices.
  solver.Minimise(std::vector<double>(9, 1.0), 3, 3, &result);
  EXPECT_EQ(result, (std::vector<int>{0, 1, 2}));
  solver.Minimise({}, 0, 4, &result);
  EXPECT_TRUE(result.empty());
  solver.Minimise({}, 2, 0, &result);
  EXPECT_EQ(result, (std::vector<int>{-1, -1}));
  for (const std::vector<double>& cost :
       {std::vector<double>{1, std::nan("")}, {1, 2, 3}}) {
    EXPECT_THROW(solver.Minimise(cost, 1, 2, &result), std::invalid_argument);
  }
}

TEST(HungarianTest, FindsTheKnownOptimumOfALargeProblem) {
  // c_ij = u_i + v_j + slack, where the slack is 0 on one permutation and
  // positive elsewhere: (u, v) is a feasible dual solution of the same cost, so
  // the permutation is the optimum.
  constexpr int kSize = 120;
  Random random(11);
  std::vector<int> permutation(kSize);
  std::vector<double> u(kSize), v(kSize), cost(kSize * kSize);
  for (int i = 0; i < kSize; ++i) {
    permutation[i] = i * 7 % kSize;
    u[i] = random.Uniform(-10, 10);
    v[i] = random.Uniform(-10, 10);
  }
  for (int i = 0; i < kSize * kSize; ++i) {
    const int r = i / kSize, c = i % kSize;
    const double slack = permutation[r] == c ? 0.0 : random.Uniform(0.1, 5.0);
    cost[i] = u[r] + v[c] + slack;
  }
  HungarianSolver solver;
  std::vector<int> result;
  solver.Minimise(cost, kSize, kSize, &result);
  EXPECT_EQ(result, permutation);
}

// Compared with the solution for the whole matrix, in which pairs without gain
// are set to zero.
TEST(MaximisePositive, FindsTheLargestTotalOfPositivePairs) {
  Random random(7);
  for (int trial = 0; trial < 200; ++trial) {
    Problem gains{static_cast<int>(1 + random.Index(12)),
                  static_cast<int>(1 + random.Index(12)),
                  {}};
    for (int i = 0; i < gains.rows * gains.cols; ++i) {
      gains.cost.push_back(random.Chance(0.2) ? random.Uniform()
                                              : -random.Uniform());
    }
    Problem clipped = gains;
    for (double& gain : clipped.cost) gain = std::max(0.0, gain);
    std::vector<int> whole, parts;
    HungarianSolver solver;
    solver.Maximise(clipped.cost, gains.rows, gains.cols, &whole);
    solver.MaximisePositive(gains.cost, gains.rows, gains.cols, &parts);
    for (int r = 0; r < gains.rows; ++r) {
      if (whole[r] >= 0 && !(gains.cost[r * gains.cols + whole[r]] > 0.0)) {
        whole[r] = -1;
      }
    }
    EXPECT_EQ(parts, whole) << "trial " << trial;
  }
}

TEST(MaximisePositive, RejectsInvalidGains) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  HungarianSolver solver;
  std::vector<int> result;
  for (const std::vector<double>& gain :
       {std::vector<double>{1, std::nan("")}, {1, kInfinity}, {1}, {1, 2, 3}}) {
    EXPECT_THROW(solver.MaximisePositive(gain, 1, 2, &result),
                 std::invalid_argument);
  }
  solver.MaximisePositive(std::vector<double>{1, -kInfinity}, 1, 2, &result);
  EXPECT_EQ(result, std::vector<int>{0});
}

}  // namespace
}  // namespace kinegraph
