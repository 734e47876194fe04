// Checks which solvers a run uses, by its counts of solves, and properties of
// CeresSolver and PersonSolver. Sweeps are the iterations of the
// block-tridiagonal solver.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "solvers/batch/batch_estimator.h"
#include "solvers/ceres/ceres_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/person/person_solver.h"
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

TEST_F(DefaultSolverTest, EverySolveBuildsACeresProblem) {
  for (const bool batch : {false, true}) {
    for (const bool bones : {false, true}) {
      SCOPED_TRACE(::testing::Message() << batch << bones);
      GraphOptions options;
      options.bones = bones;
      const SolveCounts counts = Run(batch, 30, options);
      EXPECT_EQ(counts.solves, batch ? 1 : 30);
      EXPECT_EQ(counts.ceres_problems, counts.solves);
      EXPECT_GT(counts.sweep_iterations, 0);
      EXPECT_TRUE(counts.AllWell()) << DescribeTroubles(counts);
    }
  }
}

TEST_F(DefaultSolverTest, CeresIteratesIfTheSweepsDidNotConverge) {
  GraphOptions options;
  options.max_iterations = 1;  // of the sweeps, and then of Ceres
  options.step_tolerance_m = 1e-9;
  const SolveCounts counts = Run(false, 30, options);
  EXPECT_EQ(counts.ceres_problems, 30);
  EXPECT_GT(counts.ceres_iterations, 15);
}

TEST_F(DefaultSolverTest, CeresRunsAllStagesWhenStartingFromDlt) {
  for (const bool bones : {false, true}) {
    GraphOptions options;
    options.start = GraphStart::kDlt;
    options.bones = bones;
    const SolveCounts counts = Run(false, 30, options);
    EXPECT_EQ(counts.sweep_iterations, 0);
    EXPECT_EQ(counts.solves, 30);
    // Bones are learnt from estimates without bones, which are solved first.
    EXPECT_EQ(counts.ceres_problems, bones ? 60 : 30);
    EXPECT_GT(counts.ceres_iterations, 30);
    EXPECT_TRUE(counts.AllWell()) << DescribeTroubles(counts);
  }
}

TEST_F(DefaultSolverTest, BlockTridiagonalBuildsNoCeresProblem) {
  GraphOptions options;
  options.solver = GraphSolver::kBlockTridiagonal;
  const SolveCounts counts = Run(false, 30, options);
  EXPECT_EQ(counts.ceres_problems, 0);
  EXPECT_EQ(counts.solves, 30 * 3);  // three joints, each solved separately
}

TEST_F(DefaultSolverTest, SolvesThatDoNotConvergeAreReported) {
  GraphOptions options;
  options.solver = GraphSolver::kBlockTridiagonal;
  options.max_iterations = 1;
  options.step_tolerance_m = 1e-12;
  const SolveCounts counts = Run(true, 20, options);
  EXPECT_GT(counts.not_converged, 0);
  EXPECT_NE(DescribeTroubles(counts).find("did not converge"),
            std::string::npos);
}

// Block-tridiagonal solves that only provide Ceres' start are not counted, nor
// are their failures, of which there is one for every joint here.
TEST_F(DefaultSolverTest, NoMoreFailuresThanSolves) {
  GraphOptions options;
  options.loss_scale = 1e300;
  for (const bool batch : {false, true}) {
    const SolveCounts counts = Run(batch, 20, options);
    EXPECT_EQ(counts.solves, batch ? 1 : 20);
    EXPECT_LE(counts.not_finite, counts.solves);
    EXPECT_LE(counts.no_covariance, counts.solves);
  }
}

int ThreadsOfThisProcess() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

// A long problem with bones, which Ceres has to factorise. Threads that a
// library starts internally persist after the call, so it suffices to count
// them afterwards.
class CeresThreadsTest : public testing::SolverProblemTest {};

TEST_F(CeresThreadsTest, CeresStartsNoThread) {
  Make({4, 700, 71, false, 0}, SimulatedNoise());
  for (const Bone& bone : scene_.skeleton.bones()) {
    problem_.bones.push_back({bone.a, bone.b, 0.3, 0.02});
  }
  const int before = ThreadsOfThisProcess();
  const SolveReport report =
      CeresSolver().Solve(MakeSchedule(GraphOptions()), &problem_);
  EXPECT_GT(report.ceres_iterations, 3);
  EXPECT_EQ(ThreadsOfThisProcess(), before);
}

// A solver's result must be bitwise independent of its earlier solves, because
// each chunk of a batch uses any idle solver.
class CeresSolverTest : public testing::SolverProblemTest {};

TEST_F(CeresSolverTest, ResultDoesNotDependOnEarlierSolves) {
  SimulatedNoise noise;
  noise.outliers = 0.1;
  noise.missing = 0.2;
  const SolveSchedule schedule = MakeSchedule(GraphOptions());
  CeresSolver lasting;
  for (const auto& [frames, bones] : std::vector<std::pair<int, bool>>{
           {20, false}, {12, false}, {25, false}, {25, true}, {9, true}}) {
    Make({4, frames, 71, false, 0}, noise);
    if (bones) {
      for (const Bone& bone : scene_.skeleton.bones()) {
        problem_.bones.push_back({bone.a, bone.b, 0.3, 0.02});
      }
    }
    PersonProblem fresh = problem_;
    const SolveReport expected = CeresSolver().Solve(schedule, &fresh);
    EXPECT_TRUE(expected.converged);
    const SolveReport report = lasting.Solve(schedule, &problem_);
    EXPECT_EQ(report.ceres_iterations, expected.ceres_iterations);
    for (size_t j = 0; j < fresh.joints.size(); ++j) {
      EXPECT_EQ(problem_.joints[j].states, fresh.joints[j].states);
    }
  }
}

// With graph.start = "dlt" only Refine solves with the bones. If it fails,
// covariances must not include them.
TEST_F(CeresSolverTest, AFailedSolveFromDltDropsTheBones) {
  Make({4, 20, 71, false, 0}, SimulatedNoise());
  GraphOptions options;
  options.start = GraphStart::kDlt;
  PersonSolver solver(options);
  const std::vector<Bone>& bones = scene_.skeleton.bones();
  problem_.bones.push_back({bones[0].a, bones[0].b, 0.3, 0.02});
  solver.Refine(&problem_);
  EXPECT_EQ(problem_.bones.size(), 1u);
  EXPECT_EQ(solver.ExtractCounts().bones_dropped, 0);
  problem_.bones[0].length_m = std::nan("");
  solver.Refine(&problem_);
  EXPECT_TRUE(problem_.bones.empty());
  const SolveCounts counts = solver.ExtractCounts();
  EXPECT_EQ(counts.not_finite, 1);
  EXPECT_EQ(counts.bones_dropped, 1);
}

class PersonSolverTest : public testing::SolverProblemTest {};

// A marginal prior couples joints even if there are no bones, so a solve can
// fail without any bones to drop.
TEST_F(PersonSolverTest, AFailedSolveDropsOnlyBonesThatExist) {
  GraphOptions options;
  options.solver = GraphSolver::kBlockTridiagonal;
  for (const bool bones : {false, true}) {
    SCOPED_TRACE(bones);
    Make({4, 20, 71, false, 0}, SimulatedNoise());
    const auto size =
        static_cast<Eigen::Index>(kStateSize * problem_.joints.size());
    PersonPrior& prior = problem_.prior;
    prior.A = Eigen::MatrixXd::Identity(size, size);
    prior.x0 = Eigen::VectorXd::Constant(size, std::nan(""));
    prior.b = Eigen::VectorXd::Zero(size);
    prior.information = prior.stated = prior.A;
    if (bones) {
      const Bone& bone = scene_.skeleton.bones()[0];
      problem_.bones.push_back({bone.a, bone.b, 0.3, 0.02});
    }
    PersonSolver solver(options);
    solver.SolveBones(&problem_);
    EXPECT_TRUE(problem_.bones.empty());
    const SolveCounts counts = solver.ExtractCounts();
    EXPECT_EQ(counts.not_finite, 1);
    EXPECT_EQ(counts.bones_dropped, bones ? 1 : 0);
  }
}

// If a solve fails, weights at its states must not make views inliers, nor
// replace the zero weights that an earlier solve gave to unconverged states.
TEST_F(CeresSolverTest, AFailedSolveKeepsTheWeights) {
  Make({4, 20, 71, false, 0}, SimulatedNoise());
  const Bone& bone = scene_.skeleton.bones()[0];
  problem_.bones.push_back({bone.a, bone.b, std::nan(""), 0.02});
  for (PixelMeasurement& m : problem_.joints[0].measurements) m.weight = 0.5;
  const SolveReport report =
      CeresSolver().Solve(MakeSchedule(GraphOptions()), &problem_);
  EXPECT_FALSE(report.finite);
  for (size_t j = 0; j < problem_.joints.size(); ++j) {
    for (const PixelMeasurement& m : problem_.joints[j].measurements) {
      EXPECT_EQ(m.weight, j == 0 ? 0.5 : 0.0);
    }
  }
}

// The last step of the block-tridiagonal solver, whose states Ceres starts
// from, may move a state behind a camera that sees the joint.
TEST_F(CeresSolverTest, AStartBehindACameraIsGated) {
  Make({4, 20, 71, false, 0}, SimulatedNoise());
  const SolveSchedule schedule = MakeSchedule(GraphOptions());
  ASSERT_TRUE(CeresSolver().Solve(schedule, &problem_).converged);
  JointChain& chain = problem_.joints[1];
  const Camera& camera = *chain.measurements[chain.first[9]].camera;
  chain.states[9].head<3>() = 2.0 * camera.centre();
  const SolveReport report = CeresSolver().Solve(schedule, &problem_);
  EXPECT_TRUE(report.finite);
  EXPECT_TRUE(chain.measurements[chain.first[9]].gated);
  EXPECT_EQ(chain.measurements[chain.first[9]].weight, 0.0);
}

// A joint that approaches the camera of its only view must not reach it, where
// its information would be unbounded. The prior of the body's centre prevents
// this.
TEST_F(CeresSolverTest, JointInOneViewStaysNearThePerson) {
  Make({1, 200, 71, false, 0}, SimulatedNoise());
  // The pixels move outwards, as if the joints approached the camera.
  for (JointChain& chain : problem_.joints) {
    const Camera& camera = *chain.measurements.front().camera;
    const Eigen::Vector2d middle(camera.model().cx, camera.model().cy);
    for (size_t k = 0; k < chain.states.size(); ++k) {
      PixelMeasurement& measurement = chain.measurements[chain.first[k]];
      const double grown = 1.0 + 0.02 * static_cast<double>(k);
      measurement.px = middle + grown * (measurement.px - middle);
    }
  }
  const SolveReport report =
      CeresSolver().Solve(MakeSchedule(GraphOptions()), &problem_);
  EXPECT_TRUE(report.finite);
  EXPECT_TRUE(report.converged);
  for (const JointChain& chain : problem_.joints) {
    for (size_t k = 0; k < chain.states.size(); ++k) {
      // The limit, 3 * 160^(1/8) * 1.2 = 6.8 m, is 2.3 standard deviations,
      // each (4 q R^3)^(1/8) = 2.9 m, of the position of a joint whose velocity
      // is a random walk of power q = 6 m^2/s^3 (wrist), observed with noise
      // density R = 6 m^2 s: the prior of the body's centre has a sigma of 1 m
      // and a correlation time of 3 s.
      EXPECT_LT(
          (chain.states[k].head<3>() - problem_.centres[k].position_m).norm(),
          3.0 * std::pow(16.0 * 10.0, 0.125) * 1.2);
      EXPECT_GT(
          chain.measurements.front().camera->Depth(chain.states[k].head<3>()),
          kNearestDepthM);
    }
  }
  std::vector<std::vector<Matrix6d>> covariances;
  EXPECT_TRUE(
      PersonCovariances(problem_, 1.0, problem_.times.size(), &covariances));
}

}  // namespace
}  // namespace kinegraph
