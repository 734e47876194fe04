// Which solver a default run uses, told by its counts: no debugger needed.
#include <glog/logging.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "solvers/batch/batch_estimator.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

using testing::SimulatedNoise;
using testing::SimulatedTake;

class DefaultSolverTest : public ::testing::Test {
 protected:
  SolveCounts Run(bool batch, int frames, const GraphOptions& given) {
    SceneModel scene =
        testing::SmallScene(testing::RingOfCameras(4, 5.0, 1000.0), 25.0);
    GraphOptions options = given;
    options.max_iterations = given.max_iterations == 1 ? 1 : 100;
    options.ledger = std::make_shared<SolveLedger>();
    Random random(71);
    SimulatedTake take =
        testing::Simulate(scene, options, testing::WalkingMotion(scene, frames),
                          SimulatedNoise(), Eigen::Vector3d::Zero(), &random);
    const auto estimator = batch ? MakeBatchEstimator(scene, options)
                                 : MakeWindowEstimator(scene, options);
    testing::Run(estimator.get(), take.frames);
    return options.ledger->Total();
  }
};

GraphOptions Ceres() {
  GraphOptions options;
  options.solver = GraphSolver::kCeres;
  return options;
}

// Keeps what VLOG writes.
class LogText final : public google::LogSink {
 public:
  LogText() { google::AddLogSink(this); }
  ~LogText() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity, const char*, const char*, int,
            const struct ::tm*, const char* message, size_t length) override {
    text.append(message, length);
  }
  std::string text;
};

TEST_F(DefaultSolverTest, TheWindowBuildsACeresProblemAFrame) {
  const SolveCounts counts = Run(false, 30, Ceres());
  EXPECT_EQ(counts.ceres_problems, 30);
  EXPECT_EQ(counts.solves, 30);
  EXPECT_GE(counts.ceres_iterations, 30);
  EXPECT_GT(counts.sweep_iterations, 30);
  EXPECT_EQ(counts.cholmod_problems, 0);  // windows are Eigen's
  EXPECT_TRUE(counts.AllWell()) << DescribeTroubles(counts);
}

TEST_F(DefaultSolverTest, ALongBatchWithBonesCallsCholmod) {
  GraphOptions options = Ceres();
  options.bones = true;
  options.chunk_s = 0.0;  // a whole skeleton has as many blocks in ten seconds
  FLAGS_v = 2;
  LogText log;
  // 700 frames of three joints: 2100 blocks.
  const SolveCounts counts = Run(true, 700, options);
  FLAGS_v = 0;
  EXPECT_EQ(counts.ceres_problems, 1);
  EXPECT_EQ(counts.cholmod_problems, 1);
  EXPECT_TRUE(counts.AllWell()) << DescribeTroubles(counts);
  // Ceres' own words.
  EXPECT_NE(log.text.find("SUITE_SPARSE"), std::string::npos) << log.text;
  EXPECT_NE(log.text.find("SPARSE_NORMAL_CHOLESKY"), std::string::npos);
}

TEST_F(DefaultSolverTest, SweepsBuildNone) {
  GraphOptions options;
  options.solver = GraphSolver::kSweeps;
  const SolveCounts counts = Run(false, 30, options);
  EXPECT_EQ(counts.ceres_problems, 0);
  EXPECT_EQ(counts.solves, 30 * 3);
}

TEST_F(DefaultSolverTest, WhatDoesNotConvergeIsSaid) {
  GraphOptions options;
  options.solver = GraphSolver::kSweeps;
  options.max_iterations = 1;
  options.step_tolerance_m = 1e-12;
  const SolveCounts counts = Run(true, 20, options);
  EXPECT_GT(counts.not_converged, 0);
  EXPECT_NE(DescribeTroubles(counts).find("did not converge"),
            std::string::npos);
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
            "graph.max_iterations steps (--set=graph.max_iterations=1000 goes "
            "on)");
  SolveCounts sum = counts;
  sum += counts;
  EXPECT_EQ(sum.solves, 20);
  EXPECT_EQ(sum.not_converged, 4);
}

}  // namespace
}  // namespace kinegraph
