#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/base/instruction_set.h"
#include "core/base/pack.h"
#include "solvers/batch/batch_estimator.h"
#include "solvers/block_tridiagonal/bone_solver.h"
#include "solvers/block_tridiagonal/chain_solver.h"
#include "solvers/block_tridiagonal/person_system.h"
#include "solvers/ceres/ceres_factor.h"
#include "solvers/ceres/ceres_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/factor_list.h"
#include "solvers/graph/marginalise.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/solver_problem.h"

namespace kinegraph {
namespace {

using testing::ExpectSameStates;
using testing::SimulatedNoise;

// Expects that Ceres finds the minimum `ours` from the same start, and stays
// there when started from `ours`.
void ExpectMinimumOfCeres(const SolveSchedule& schedule, PersonProblem start,
                          const PersonProblem& ours, double tolerance_m) {
  EXPECT_TRUE(CeresSolver().Solve(schedule, &start).finite);
  ExpectSameStates(ours, start, tolerance_m);
  for (size_t j = 0; j < ours.joints.size(); ++j) {
    for (size_t m = 0; m < ours.joints[j].measurements.size(); ++m) {
      // Bounds the change of a weight over `tolerance_m`, i.e. over much less
      // than a pixel.
      EXPECT_NEAR(ours.joints[j].measurements[m].weight,
                  start.joints[j].measurements[m].weight, 1e-5);
    }
  }
  SolveSchedule last = schedule;
  last.stages.erase(last.stages.begin());
  PersonProblem from_ours = ours;
  CeresSolver().Solve(last, &from_ours);
  ExpectSameStates(ours, from_ours, 1e-8);
}

// Expects found[k] to be the block of joint `joint` in frame k of the dense
// covariance of `joints` joints, up to `share` of the norm of the block.
void ExpectBlocksOf(const Eigen::MatrixXd& dense, size_t joint, size_t joints,
                    const std::vector<Matrix6d>& found, double share) {
  ASSERT_EQ(found.size() * joints * 6, static_cast<size_t>(dense.rows()));
  for (size_t k = 0; k < found.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(6 * (joints * k + joint));
    const Matrix6d expected = dense.block<6, 6>(at, at);
    EXPECT_LT((found[k] - expected).norm(), share * expected.norm())
        << joint << " " << k;
  }
}

// The dense inverse of the person's information at the stored weights, ordered
// by frame; the information of observations is multiplied by `correction`.
Eigen::MatrixXd DenseCovariance(const PersonProblem& problem,
                                double correction = 1.0) {
  const size_t joints = problem.joints.size();
  const auto place = [&](const StateKey& key) {
    return static_cast<Eigen::Index>(6 * (joints * key.frame + key.joint));
  };
  const auto size =
      static_cast<Eigen::Index>(6 * joints * problem.times.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  const auto add = [&](const auto& factor, const auto& keys,
                       const Robustness& robustness) {
    using Factor = std::decay_t<decltype(factor)>;
    Linearised<Factor> at;
    if (!LineariseFactor(factor, keys, problem, &at)) {
      ADD_FAILURE() << "a joint has no image in a view that measures it";
      return false;
    }
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(Factor::kResiduals, size);
    for (size_t i = 0; i < keys.size(); ++i) {
      for (int row = 0; row < Factor::kResiduals; ++row) {
        for (int column = 0; column < kStateSize; ++column) {
          jacobian(row, place(keys[i]) + column) = at.by_states[i](row, column);
        }
      }
    }
    const double weight = WeightAtEstimate(problem.joints[keys[0].joint],
                                           robustness, at.squared_norm()) *
                          (robustness.measurement >= 0 ? correction : 1.0);
    information +=
        robustness.information * weight * jacobian.transpose() * jacobian;
    return true;
  };
  testing::ForEachFactor(problem, FactorWalk(), add);
  if (!problem.prior.empty()) {
    information.topLeftCorner(6 * joints, 6 * joints) +=
        problem.prior.A.transpose() * problem.prior.A;
  }
  return information.inverse();
}

// Each camera captures 2 ms later than the previous one.
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
    SCOPED_TRACE(LossNames()[static_cast<size_t>(loss)]);
    const SolveSchedule schedule = Exact(loss, 3.0);
    PersonProblem ours = problem_;
    ChainSolver solver;
    for (JointChain& chain : ours.joints) {
      const SolveReport report = solver.Solve(ours, schedule, {&chain}).front();
      EXPECT_TRUE(report.finite);
      EXPECT_TRUE(report.converged) << report.iterations;
    }
    // Ceres stops where rounding, 1e-16 of a cost of about 1e3, hides its
    // progress: with a curvature of 1e3 / m^2 or more, at sqrt(1e-13 / 1e3) =
    // 1e-8 m from the minimum, and at ten times that where reweighting
    // converges slowly.
    ExpectMinimumOfCeres(schedule, problem_, ours, 1e-7);
  }
}

// The covariances of all frames of one chain.
std::vector<Matrix6d> CovariancesOf(const PersonProblem& problem,
                                    const JointChain& chain,
                                    double correction) {
  return ChainSolver()
      .Covariances(problem, {&chain}, correction, problem.times.size())
      .front();
}

TEST_F(ChainSolverTest, CovariancesEqualBlocksOfTheDenseInverse) {
  SimulatedNoise noise;
  noise.missing = 0.3;
  Make(3, 25, noise);
  JointChain& chain = problem_.joints[0];
  ChainSolver solver;
  solver.Solve(problem_, Exact(LossKind::kGemanMcClure, 3.0), {&chain});
  const auto covariances = CovariancesOf(problem_, chain, 1.1);
  problem_.joints.resize(1);
  // The information's condition is about 1e7: 1e-16 times that, with a margin.
  ExpectBlocksOf(DenseCovariance(problem_, 1.1), 0, 1, covariances, 1e-8);
}

TEST_F(ChainSolverTest, HasFullRankWithOneViewOrNone) {
  for (const int views : {0, 1}) {
    Make(views == 0 ? 1 : views, 20, SimulatedNoise());
    JointChain& chain = problem_.joints[0];
    if (views == 0) {
      // Birth and motion alone.
      problem_.centres.assign(problem_.times.size(), {});
      chain.measurements.clear();
      chain.first.assign(chain.states.size() + 1, 0);
    }
    ChainSolver solver;
    const SolveReport report =
        solver.Solve(problem_, Exact(LossKind::kGemanMcClure, 3.0), {&chain})
            .front();
    EXPECT_TRUE(report.finite);
    problem_.joints.resize(1);
    const Eigen::MatrixXd dense = DenseCovariance(problem_);
    EXPECT_TRUE(dense.allFinite());
    const auto covariances = CovariancesOf(problem_, chain, 1.0);
    ExpectBlocksOf(dense, 0, 1, covariances, 1e-7);
    if (views == 0) {
      // Birth and motion: sigma^2 + (3 m/s * t)^2 + q t^3 / 3 along each axis.
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
  // The joint cannot be projected into camera 0 in any of the ten frames.
  EXPECT_GE(gated, 10);
  ChainSolver solver;
  const SolveReport report =
      solver.Solve(problem_, Exact(LossKind::kGemanMcClure, 3.0), {&chain})
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

// A joint's result depends neither on the other lanes nor on the number of
// lanes.
TEST_F(ChainSolverTest, ResultIsBitwiseIndependentOfGroupAndInstructionSet) {
  SimulatedNoise noise;
  noise.outliers = 0.1;
  noise.missing = 0.2;
  noise.confidence_low = 0.3;
  Make(5, 30, noise);
  // Three copies of the arm: more joints than a group has lanes.
  std::vector<JointChain> joints = problem_.joints;
  joints.insert(joints.end(), problem_.joints.begin(), problem_.joints.end());
  joints.insert(joints.end(), problem_.joints.begin(), problem_.joints.end());
  ASSERT_GT(joints.size(), static_cast<size_t>(kLaneMultiple));
  // One joint without measurements, one behind a camera.
  joints[1].measurements.clear();
  joints[1].first.assign(joints[1].states.size() + 1, 0);
  for (State& state : joints[4].states) {
    state.head<3>() = 20.0 * scene_.cameras[0].centre();
  }
  SolveSchedule schedule = Exact(LossKind::kGemanMcClure, 3.0);
  schedule.stages.back().max_iterations = 7;  // not all of them converge
  UseInstructionSet(InstructionSet::kBaseline);
  ChainSolver solver;
  std::vector<JointChain> alone = joints;
  std::vector<SolveReport> reports;
  std::vector<std::vector<Matrix6d>> covariances(joints.size());
  for (size_t j = 0; j < joints.size(); ++j) {
    reports.push_back(solver.Solve(problem_, schedule, {&alone[j]}).front());
    covariances[j] = CovariancesOf(problem_, alone[j], 1.1);
  }
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2,
        InstructionSet::kAvx512}) {
    SCOPED_TRACE(ToString(set));
    UseInstructionSet(set);
    std::vector<JointChain> together = joints;
    std::vector<JointChain*> chains;
    for (JointChain& chain : together) chains.push_back(&chain);
    const auto all = solver.Solve(problem_, schedule, chains);
    const auto blocks =
        solver.Covariances(problem_, {chains.begin(), chains.end()}, 1.1, 30);
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

class BoneTest : public testing::SolverProblemTest {
 protected:
  void Make(int cameras, int frames, const SimulatedNoise& noise) {
    SolverProblemTest::Make({cameras, frames, 51, false, 0}, noise);
    for (const Bone& bone : scene_.skeleton.bones()) {
      problem_.bones.push_back(
          {bone.a, bone.b, TrueLength(bone), options_.bone_sigma_m});
    }
  }

  double TrueLength(const Bone& bone) const {
    return (recording_.truth[bone.a][0] - recording_.truth[bone.b][0])
        .head<3>()
        .norm();
  }
};

TEST_F(BoneTest, FindsTheMinimumThatCeresFinds) {
  SimulatedNoise noise;
  noise.outliers = 0.1;
  noise.missing = 0.2;
  Make(4, 30, noise);
  for (const LossKind loss : {LossKind::kNone, LossKind::kGemanMcClure}) {
    const SolveSchedule schedule = Exact(loss);
    PersonProblem own = problem_;
    EXPECT_TRUE(BoneSolver().Solve(schedule, &own).finite);
    // Three times the tolerance of
    // ChainSolverTest.FindsTheMinimumThatCeresFinds.
    ExpectMinimumOfCeres(schedule, problem_, own, 3e-7);
  }
}

TEST_F(BoneTest, CovariancesEqualBlocksOfTheDenseInverse) {
  Make(3, 70, SimulatedNoise());
  BoneSolver solver;
  solver.Solve(Exact(LossKind::kNone), &problem_);
  const Eigen::MatrixXd dense = DenseCovariance(problem_);
  // In one segment, and in nine: a segment has at least eight of the 70 frames.
  // From the second segment on, the results of the backward sweep are
  // recomputed.
  for (const size_t segment_bytes : {16 << 20, 1}) {
    std::vector<std::vector<Matrix6d>> covariances;
    ASSERT_TRUE(
        PersonCovariances(problem_, 1.0, 70, &covariances, segment_bytes));
    for (size_t j = 0; j < 3; ++j) {
      ExpectBlocksOf(dense, j, 3, covariances[j], 1e-7);
    }
  }
}

TEST_F(BoneTest, MarginalisingKeepsValuesAndCovariances) {
  Make(3, 10, SimulatedNoise());
  BoneSolver solver;
  const SolveSchedule schedule = Exact(LossKind::kNone);
  solver.Solve(schedule, &problem_);
  const Eigen::MatrixXd before = DenseCovariance(problem_);
  PersonProblem rest = problem_;
  for (int dropped = 1; dropped <= 3; ++dropped) {
    DropFirstFrame(1.0, &rest);
    const Eigen::MatrixXd after = DenseCovariance(rest);
    EXPECT_LT(
        (after - before.bottomRightCorner(after.rows(), after.rows())).norm(),
        1e-7 * before.norm());
  }
  PersonProblem again = rest;
  solver.Solve(schedule, &again);
  ExpectSameStates(again, rest, 1e-8);
  PersonProblem by_ceres = rest;
  CeresSolver().Solve(schedule, &by_ceres);
  ExpectSameStates(by_ceres, rest, 1e-8);
}

// A joint that has not been observed for a long time retains little information
// compared with the subtracted information of the motion between two frames.
TEST_F(BoneTest, MarginalisingKeepsAJointWithoutObservations) {
  constexpr size_t kFrames = 200;
  constexpr size_t kSeen = 5;
  Make(3, kFrames, SimulatedNoise());
  JointChain& unseen = problem_.joints[2];
  unseen.measurements.resize(unseen.first[kSeen]);
  std::fill(unseen.first.begin() + kSeen, unseen.first.end(),
            unseen.first[kSeen]);
  problem_.bones.resize(1);
  ASSERT_NE(problem_.bones[0].a, 2);
  ASSERT_NE(problem_.bones[0].b, 2);
  BoneSolver solver;
  solver.Solve(Exact(LossKind::kNone), &problem_);
  std::vector<std::vector<Matrix6d>> before;
  ASSERT_TRUE(PersonCovariances(problem_, 1.0, kFrames, &before));
  PersonProblem rest = problem_;
  for (size_t dropped = 1; dropped < kFrames; ++dropped) {
    DropFirstFrame(1.0, &rest);
    ASSERT_FALSE(rest.prior.empty()) << dropped;
  }
  std::vector<std::vector<Matrix6d>> after;
  ASSERT_TRUE(PersonCovariances(rest, 1.0, 1, &after));
  // With white noise of power q on acceleration, the motion between two frames
  // dt apart has the information 12 / (q dt^3) on a position, and after a time
  // T without a view the information on a position is 3 / (q T^3). Sums of 18
  // products leave an error of 18 units of rounding of the former in every
  // frame: for 200 frames at 25 Hz at most 200 * 18 * 2.2e-16 * 4 * 200^3 =
  // 3e-5 of the latter.
  for (size_t j = 0; j < after.size(); ++j) {
    const Matrix6d& expected = before[j][kFrames - 1];
    EXPECT_LT((after[j][0] - expected).norm(), 3e-5 * expected.norm()) << j;
  }
}

// Reported covariances include the loss' correction also for marginalised
// frames.
TEST_F(BoneTest, MarginalisingKeepsReportedCovariances) {
  Make(3, 10, SimulatedNoise());
  BoneSolver().Solve(Exact(LossKind::kGemanMcClure), &problem_);
  testing::ExpectMarginalisationKeepsCovariances(1.3, problem_);
}

// Bones stabilise both estimators: lengths vary less, and errors shrink.
TEST_F(BoneTest, BonesReduceErrorAndSpread) {
  SimulatedNoise noise;
  noise.correlation_time_s = 0.1;
  noise.missing = 0.3;
  Make(3, 250, noise);
  for (const bool batch : {true, false}) {
    double rmse_m[2];
    double spread_m[2];
    for (const bool bones : {false, true}) {
      GraphOptions options = testing::FixedNoise();
      options.bones = bones;
      const auto estimator = testing::MakeEstimator(batch, scene_, options);
      const auto finals = testing::Run(estimator.get(), recording_.frames);
      rmse_m[bones] = testing::RootMeanSquare(recording_.truth, finals, 100);
      std::vector<double> lengths_m;
      for (size_t k = 100; k < finals.size(); ++k) {
        const PersonPose& person = finals[k].person;
        const auto& joints = person.joints;
        if (!joints[0].present() || !joints[1].present()) continue;
        EXPECT_TRUE(person.covariances[0].has_value());
        lengths_m.push_back(testing::Apart(joints[0], joints[1]));
      }
      const Eigen::Map<const Eigen::ArrayXd> lengths(
          lengths_m.data(), static_cast<Eigen::Index>(lengths_m.size()));
      spread_m[bones] = std::sqrt((lengths - lengths.mean()).square().mean());
    }
    EXPECT_LT(rmse_m[1], rmse_m[0]);
    EXPECT_LT(spread_m[1], 0.7 * spread_m[0]);
  }
}

}  // namespace
}  // namespace kinegraph
