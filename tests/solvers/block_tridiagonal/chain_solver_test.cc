#include "solvers/block_tridiagonal/chain_solver.h"

#include <ceres/covariance.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/base/instruction_set.h"
#include "core/base/pack.h"
#include "solvers/block_tridiagonal/linear_chain.h"
#include "solvers/ceres/ceres_factor.h"
#include "solvers/ceres/ceres_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/factor_list.h"
#include "tests/support/solver_problem.h"

namespace kinegraph {
namespace {

using testing::SimulatedNoise;

// Some cameras a little late.
class ChainSolverTest : public testing::SolverProblemTest {
 protected:
  void Make(int cameras, int frames, const SimulatedNoise& noise) {
    SolverProblemTest::Make({cameras, frames, 17, true, 2'000'000}, noise);
  }
};

TEST_F(ChainSolverTest, FindsTheMinimumThatCeresFinds) {
  SimulatedNoise noise;
  noise.outliers = 0.1;
  noise.missing = 0.1;
  noise.confidence_low = 0.3;
  Make(5, 40, noise);
  for (const LossKind loss :
       {LossKind::kNone, LossKind::kHuber, LossKind::kCauchy,
        LossKind::kGemanMcClure, LossKind::kTukey}) {
    const SolveSchedule schedule = Exact(loss, 3.0);
    SolveSchedule last = schedule;
    last.stages.erase(last.stages.begin());
    PersonProblem by_ceres = problem_;
    SolveWithCeres(schedule, &by_ceres);
    // Ceres stops where rounding hides the progress of the cost, a part in
    // 1e16 of about 1e3 under a curvature of 1e3 / m^2 and more: 1e-8 m, and
    // ten times that where reweighting converges slowly.
    PersonProblem from_ours = problem_;
    ChainSolver solver;
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      JointChain chain = problem_.joints[j];
      const SolveReport report =
          solver.Solve(problem_.times, schedule, {&chain}).front();
      EXPECT_TRUE(report.finite);
      EXPECT_TRUE(report.converged) << report.iterations;
      for (size_t k = 0; k < chain.states.size(); ++k) {
        EXPECT_LT(
            (chain.states[k] - by_ceres.joints[j].states[k]).head<3>().norm(),
            1e-7)
            << LossNames()[static_cast<int>(loss)] << " joint " << j
            << " frame " << k;
      }
      for (size_t m = 0; m < chain.measurements.size(); ++m) {
        EXPECT_NEAR(chain.measurements[m].weight,
                    by_ceres.joints[j].measurements[m].weight, 1e-5);
      }
      from_ours.joints[j] = chain;
    }
    // Started at our minimum, Ceres finds nothing better.
    const PersonProblem ours = from_ours;
    SolveWithCeres(last, &from_ours);
    for (size_t j = 0; j < ours.joints.size(); ++j) {
      for (size_t k = 0; k < ours.times.size(); ++k) {
        EXPECT_LT((ours.joints[j].states[k] - from_ours.joints[j].states[k])
                      .head<3>()
                      .norm(),
                  1e-8);
      }
    }
  }
}

// Of all frames of one chain.
std::vector<Matrix6d> CovariancesOf(const std::vector<TimeNs>& times,
                                    const JointChain& chain,
                                    double correction) {
  return ChainSolver()
      .Covariances(times, {&chain}, correction, times.size())
      .front();
}

// The whole information matrix, inverted densely.
Eigen::MatrixXd DenseChainCovariance(const std::vector<TimeNs>& times,
                                     const JointChain& chain,
                                     double correction) {
  LinearChain linear;
  LineariseInformation(times, chain, correction, OwnPrior::kCounts, &linear);
  const Eigen::Index size = kStateSize * times.size();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (size_t k = 0; k < times.size(); ++k) {
    const Eigen::Index at = kStateSize * k;
    information.block<6, 6>(at, at) = linear.diagonal[k];
    if (k + 1 == times.size()) break;
    information.block<6, 6>(at, at + 6) = linear.upper[k];
    information.block<6, 6>(at + 6, at) = linear.upper[k].transpose();
  }
  return information.inverse();
}

TEST_F(ChainSolverTest, CovariancesAreBlocksOfTheDenseInverse) {
  SimulatedNoise noise;
  noise.missing = 0.3;
  Make(3, 25, noise);
  JointChain& chain = problem_.joints[0];
  ChainSolver solver;
  solver.Solve(problem_.times, Exact(LossKind::kGemanMcClure, 3.0), {&chain});
  const auto covariances = CovariancesOf(problem_.times, chain, 1.1);
  ASSERT_FALSE(covariances.empty());
  const Eigen::MatrixXd dense =
      DenseChainCovariance(problem_.times, chain, 1.1);
  for (size_t k = 0; k < covariances.size(); ++k) {
    const Matrix6d expected = dense.block<6, 6>(6 * k, 6 * k);
    // The information's condition is about 1e7: 1e-16 of that, with room.
    EXPECT_LT((covariances[k] - expected).norm(), 1e-8 * expected.norm());
  }
}

TEST_F(ChainSolverTest, FullRankWithNoViewAndWithOne) {
  for (const int views : {0, 1}) {
    Make(views == 0 ? 1 : views, 20, SimulatedNoise());
    JointChain& chain = problem_.joints[0];
    if (views == 0) {
      chain.measurements.clear();
      chain.first.assign(chain.states.size() + 1, 0);
    }
    ChainSolver solver;
    const SolveReport report =
        solver
            .Solve(problem_.times, Exact(LossKind::kGemanMcClure, 3.0),
                   {&chain})
            .front();
    EXPECT_TRUE(report.finite);
    const Eigen::MatrixXd dense =
        DenseChainCovariance(problem_.times, chain, 1.0);
    EXPECT_TRUE(dense.allFinite());
    const auto covariances = CovariancesOf(problem_.times, chain, 1.0);
    ASSERT_FALSE(covariances.empty());
    for (size_t k = 0; k < covariances.size(); ++k) {
      const Matrix6d expected = dense.block<6, 6>(6 * k, 6 * k);
      EXPECT_LT((covariances[k] - expected).norm(), 1e-7 * expected.norm());
    }
    if (views == 0) {
      // Birth alone: sigma^2 + (3 m/s * t)^2 + q t^3 / 3 along each axis.
      const double t = ToSeconds(problem_.times.back());
      EXPECT_NEAR(covariances.back()(0, 0),
                  1.0 + 9.0 * t * t + chain.process_noise[0] * t * t * t / 3.0,
                  1e-6);
    }
  }
}

TEST_F(ChainSolverTest, StartsBehindACameraAreGated) {
  Make(5, 10, SimulatedNoise());
  JointChain& chain = problem_.joints[0];
  for (State& state : chain.states) {
    state.head<3>() = 20.0 * scene_.cameras[0].centre();
  }
  GateMeasurements(&chain);
  int gated = 0;
  for (const PixelMeasurement& m : chain.measurements) gated += m.gated;
  EXPECT_GE(gated, 10);
  ChainSolver solver;
  const SolveReport report =
      solver
          .Solve(problem_.times, Exact(LossKind::kGemanMcClure, 3.0), {&chain})
          .front();
  EXPECT_TRUE(report.finite);
  for (const State& state : chain.states) EXPECT_TRUE(state.allFinite());
  for (const PixelMeasurement& m : chain.measurements) {
    EXPECT_TRUE(!m.gated || m.weight == 0.0);
  }
}

void ExpectSameBits(const JointChain& a, const JointChain& b) {
  for (size_t k = 0; k < a.states.size(); ++k) {
    EXPECT_EQ(a.states[k], b.states[k]);
  }
  for (size_t m = 0; m < a.measurements.size(); ++m) {
    EXPECT_EQ(a.measurements[m].weight, b.measurements[m].weight);
    EXPECT_EQ(a.measurements[m].gated, b.measurements[m].gated);
  }
}

// A joint's result depends neither on the joints beside it nor on how many of
// them the machine computes at once.
TEST_F(ChainSolverTest, SameBitsInAnyCompanyAndOnEveryInstructionSet) {
  SimulatedNoise noise;
  noise.outliers = 0.1;
  noise.missing = 0.2;
  noise.confidence_low = 0.3;
  Make(5, 30, noise);
  // Twice the arm: more joints than a group has lanes.
  std::vector<JointChain> joints = problem_.joints;
  joints.insert(joints.end(), problem_.joints.begin(), problem_.joints.end());
  joints.insert(joints.end(), problem_.joints.begin(), problem_.joints.end());
  ASSERT_GT(joints.size(), static_cast<size_t>(kLaneMultiple));
  // Some of them unseen, some where no camera sees them.
  joints[1].measurements.clear();
  joints[1].first.assign(joints[1].states.size() + 1, 0);
  for (State& state : joints[4].states) {
    state.head<3>() = 20.0 * scene_.cameras[0].centre();
  }
  SolveSchedule schedule = Exact(LossKind::kGemanMcClure, 3.0);
  schedule.stages.back().max_iterations = 7;  // not all of them settle
  UseInstructionSet(InstructionSet::kBaseline);
  ChainSolver solver;
  std::vector<JointChain> alone = joints;
  std::vector<SolveReport> reports;
  std::vector<std::vector<Matrix6d>> covariances(joints.size());
  for (size_t j = 0; j < joints.size(); ++j) {
    reports.push_back(
        solver.Solve(problem_.times, schedule, {&alone[j]}).front());
    covariances[j] = CovariancesOf(problem_.times, alone[j], 1.1);
  }
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2,
        InstructionSet::kAvx512}) {
    SCOPED_TRACE(ToString(set));
    UseInstructionSet(set);
    std::vector<JointChain> together = joints;
    std::vector<JointChain*> chains;
    for (JointChain& chain : together) chains.push_back(&chain);
    const auto all = solver.Solve(problem_.times, schedule, chains);
    const auto blocks = solver.Covariances(
        problem_.times, {chains.begin(), chains.end()}, 1.1, 30);
    for (size_t j = 0; j < joints.size(); ++j) {
      ExpectSameBits(together[j], alone[j]);
      EXPECT_EQ(all[j].iterations, reports[j].iterations);
      EXPECT_EQ(all[j].converged, reports[j].converged);
      EXPECT_EQ(all[j].unsettled, reports[j].unsettled);
      EXPECT_EQ(blocks[j], covariances[j]);
    }
  }
  UseInstructionSet(InstructionSet::kAvx512);
}

}  // namespace
}  // namespace kinegraph
