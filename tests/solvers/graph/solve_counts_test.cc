// Counts of solves, their sums and their text.
#include "solvers/graph/solve_counts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace kinegraph {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// The counts of failures.
constexpr int64_t SolveCounts::*kTroubles[] = {
    &SolveCounts::not_converged, &SolveCounts::not_finite,
    &SolveCounts::bones_dropped, &SolveCounts::positions_in_doubt,
    &SolveCounts::no_covariance};

SolveCounts NotConvergedOnce() {
  SolveCounts counts;
  counts.solves = 1;
  counts.not_converged = 1;
  return counts;
}

TEST(SolveCounts, AllWellUnlessAFailureIsCounted) {
  SolveCounts counts;
  EXPECT_TRUE(counts.AllWell());
  counts.solves = 5;
  counts.sweep_iterations = 50;
  counts.ceres_problems = 3;
  counts.ceres_iterations = 30;
  counts.ceres_decrease_millionths = 7;
  EXPECT_TRUE(counts.AllWell());
  EXPECT_EQ(DescribeTroubles(counts), "");
  for (const auto trouble : kTroubles) {
    SolveCounts one = counts;
    one.*trouble = 1;
    EXPECT_FALSE(one.AllWell());
    EXPECT_THAT(DescribeTroubles(one), StartsWith("solves: 5; 1 "));
  }
}

// Count i is 10^i, so that a count added to another member would be noticed.
TEST(SolveCounts, AddsEachCount) {
  SolveCounts counts;
  int64_t value = 1;
  for (const auto count : kSolveCounts) {
    counts.*count = value;
    value *= 10;
  }
  SolveCounts sum = counts;
  (sum += counts) += counts;
  value = 1;
  for (const auto count : kSolveCounts) {
    EXPECT_EQ(sum.*count, 3 * value);
    value *= 10;
  }
  sum = counts;
  sum += SolveCounts();
  for (const auto count : kSolveCounts) EXPECT_EQ(sum.*count, counts.*count);
}

TEST(DescribeTroubles, NamesOnlyTheCountedFailures) {
  SolveCounts counts;
  counts.solves = 40;
  counts.not_finite = 2;
  counts.no_covariance = 3;
  EXPECT_EQ(DescribeTroubles(counts, "frames that are not of interest"),
            "solves: 40; 2 without finite solution, 3 without covariance");
  counts.bones_dropped = 4;
  counts.positions_in_doubt = 5;
  const std::string text = DescribeTroubles(counts);
  EXPECT_THAT(text, HasSubstr(", 4 continued without bones"));
  EXPECT_THAT(text, HasSubstr(", 5 joint position(s) uncertain"));
  EXPECT_THAT(text, Not(HasSubstr("max_iterations")));
}

TEST(DescribeTroubles, ReportsNonConvergenceWithFramesAndAdvice) {
  const std::string somewhere = DescribeTroubles(NotConvergedOnce());
  EXPECT_THAT(somewhere, StartsWith("solves: 1; 1 did not converge; "));
  EXPECT_THAT(somewhere, HasSubstr("or found none that lowers its cost; "));
  EXPECT_THAT(somewhere, HasSubstr(" 5 cm or more "));
  EXPECT_THAT(somewhere,
              EndsWith("(--set=graph.max_iterations=1000 may help)"));
  EXPECT_THAT(DescribeTroubles(NotConvergedOnce(), "frames 3 to 9"),
              StartsWith("solves: 1; 1 did not converge (frames 3 to 9); "));
}

TEST(SolveLedger, IsInitiallyEmpty) {
  const SolveLedger ledger;
  EXPECT_TRUE(ledger.Total().AllWell());
  EXPECT_EQ(ledger.Total().solves, 0);
  EXPECT_EQ(ledger.NotConverged(), "");
}

TEST(SolveLedger, NamesUpToThreePeopleInOrderOfFirstFrame) {
  SolveLedger ledger;
  SolveCounts well;
  well.solves = 1;
  ledger.Add(well, 0, 5);
  EXPECT_EQ(ledger.NotConverged(), "");
  ledger.Add(NotConvergedOnce(), 50, 60);
  EXPECT_EQ(ledger.NotConverged(), "a person in frames 50 to 60");
  ledger.Add(NotConvergedOnce(), 7, 99);
  // Two people may span the same frames.
  ledger.Add(NotConvergedOnce(), 7, 99);
  EXPECT_EQ(ledger.NotConverged(),
            "a person in frames 7 to 99, one in 7 to 99, one in 50 to 60");
  ledger.Add(NotConvergedOnce(), 2, 3);
  ledger.Add(NotConvergedOnce(), 80, 90);
  EXPECT_EQ(ledger.NotConverged(),
            "a person in frames 2 to 3, one in 7 to 99, one in 7 to 99, 2 "
            "more");
  EXPECT_EQ(ledger.Total().solves, 6);
  EXPECT_EQ(ledger.Total().not_converged, 5);
}

TEST(SolveLedger, CountsFromSeveralThreads) {
  SolveLedger ledger;
  constexpr int kThreads = 4;
  constexpr int kEach = 500;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&ledger, t] {
      for (int i = 0; i < kEach; ++i) ledger.Add(NotConvergedOnce(), t, i);
    });
  }
  for (std::thread& one : threads) one.join();
  EXPECT_EQ(ledger.Total().solves, kThreads * kEach);
  EXPECT_EQ(ledger.Total().not_converged, kThreads * kEach);
  EXPECT_THAT(ledger.NotConverged(),
              EndsWith(std::to_string(kThreads * kEach - 3) + " more"));
}

}  // namespace
}  // namespace kinegraph
