// Which solver a default run uses, told by its counts: no debugger needed.
#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <memory>
#include <string>

#include "solvers/batch/batch_estimator.h"
#include "solvers/ceres/ceres_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/simulated_person.h"
#include "tests/support/solver_problem.h"

namespace kinegraph {
namespace {

using testing::SimulatedNoise;
using testing::SimulatedRecording;

class DefaultSolverTest : public ::testing::Test {
 protected:
  SolveCounts Run(bool batch, int frames, const GraphOptions& given) {
    SceneModel scene =
        testing::SmallScene(testing::RingOfCameras(4, 5.0, 1000.0), 25.0);
    GraphOptions options = given;
    options.max_iterations = given.max_iterations == 1 ? 1 : 100;
    options.ledger = std::make_shared<SolveLedger>();
    SimulatedRecording recording =
        testing::Simulate(scene, options, testing::WalkingMotion(scene, frames),
                          SimulatedNoise(), 71);
    const auto estimator = testing::MakeEstimator(batch, scene, options);
    testing::Run(estimator.get(), recording.frames);
    return options.ledger->Total();
  }
};

TEST_F(DefaultSolverTest, WhereTheStartIsAtTheMinimumCeresGetsNoProblem) {
  const SolveCounts counts = Run(false, 30, GraphOptions());
  EXPECT_EQ(counts.ceres_problems, 0);
  EXPECT_EQ(counts.solves, 30);
  EXPECT_GT(counts.sweep_iterations, 30);
  EXPECT_TRUE(counts.AllWell()) << DescribeTroubles(counts);
}

TEST_F(DefaultSolverTest, WhereTheStartIsNotAtTheMinimumCeresTakesSteps) {
  GraphOptions options;
  options.max_iterations = 1;  // of the sweeps, and then of Ceres
  options.step_tolerance_m = 1e-9;
  const SolveCounts counts = Run(false, 30, options);
  EXPECT_EQ(counts.ceres_problems, 30);
  EXPECT_GT(counts.ceres_iterations, 15);
}

TEST_F(DefaultSolverTest, SweepsBuildNone) {
  GraphOptions options;
  options.solver = GraphSolver::kBlockTridiagonal;
  const SolveCounts counts = Run(false, 30, options);
  EXPECT_EQ(counts.ceres_problems, 0);
  EXPECT_EQ(counts.solves, 30 * 3);
}

TEST_F(DefaultSolverTest, WhatDoesNotConvergeIsSaid) {
  GraphOptions options;
  options.solver = GraphSolver::kBlockTridiagonal;
  options.max_iterations = 1;
  options.step_tolerance_m = 1e-12;
  const SolveCounts counts = Run(true, 20, options);
  EXPECT_GT(counts.not_converged, 0);
  EXPECT_NE(DescribeTroubles(counts).find("did not converge"),
            std::string::npos);
}

int ThreadsOfThisProcess() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

// A long problem with bones, which Ceres has to factorise. Threads that a
// library starts for itself stay for its next call.
class CeresThreadsTest : public testing::SolverProblemTest {};

TEST_F(CeresThreadsTest, CeresAndWhatItCallsStayOnTheCallersThread) {
  Make({4, 700, 71, false, 0}, SimulatedNoise());
  for (const Bone& bone : scene_.skeleton.bones()) {
    problem_.bones.push_back({bone.a, bone.b, 0.3, 0.02});
  }
  const int before = ThreadsOfThisProcess();
  const SolveReport report =
      SolveWithCeres(MakeSchedule(GraphOptions()), &problem_);
  EXPECT_GT(report.ceres_iterations, 3);
  EXPECT_EQ(ThreadsOfThisProcess(), before);
}

TEST(SolveCounts, DescribeNamesWhatWentWrong) {
  SolveCounts counts;
  counts.solves = 10;
  EXPECT_EQ(DescribeTroubles(counts), "");
  counts.not_converged = 2;
  counts.bones_dropped = 1;
  EXPECT_EQ(DescribeTroubles(counts),
            "of 10 solves 2 did not converge, 1 went on without bones; what "
            "did not converge is written as it stood after the last of "
            "graph.max_iterations steps, which moved no joint by more than 5 "
            "cm but those in doubt, which count as unseen "
            "(--set=graph.max_iterations=1000 goes on)");
  SolveCounts sum = counts;
  sum += counts;
  EXPECT_EQ(sum.solves, 20);
  EXPECT_EQ(sum.not_converged, 4);
}

TEST(SolveCounts, TheLedgerTellsWhereNothingConverged) {
  SolveLedger ledger;
  SolveCounts well;
  well.solves = 1;
  ledger.Add(well, 0, 9);
  EXPECT_EQ(ledger.NotConverged(), "");
  SolveCounts creeping = well;
  creeping.not_converged = 1;
  // In whatever order threads hand in.
  for (const int64_t first : {30, 10, 40, 20}) {
    ledger.Add(creeping, first, first + 5);
  }
  EXPECT_EQ(ledger.NotConverged(),
            "a person of frames 10 to 15, one of 20 to 25, one of 30 to 35, 1 "
            "more");
  EXPECT_NE(
      DescribeTroubles(ledger.Total(), ledger.NotConverged())
          .find("of 5 solves 4 did not converge (a person of frames 10 to 15"),
      std::string::npos);
}

}  // namespace
}  // namespace kinegraph
