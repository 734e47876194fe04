#include <ceres/covariance.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "solvers/batch/batch_estimator.h"
#include "solvers/block_tridiagonal/bone_solver.h"
#include "solvers/block_tridiagonal/person_system.h"
#include "solvers/ceres/ceres_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/factor_list.h"
#include "solvers/graph/marginalise_frame.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/solver_problem.h"

namespace kinegraph {
namespace {

using testing::SimulatedNoise;

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

void ExpectSameStates(const PersonProblem& a, const PersonProblem& b,
                      double tolerance_m) {
  for (size_t j = 0; j < a.joints.size(); ++j) {
    for (size_t k = 0; k < a.times.size(); ++k) {
      EXPECT_LT(
          (a.joints[j].states[k] - b.joints[j].states[k]).head<3>().norm(),
          tolerance_m)
          << "joint " << j << " frame " << k;
    }
  }
}

// The whole person's information, frame by frame, inverted densely.
Eigen::MatrixXd DenseCovariance(const PersonProblem& problem) {
  const size_t joints = problem.joints.size();
  const auto place = [&](const StateKey& key) {
    return static_cast<Eigen::Index>(6 * (joints * key.frame + key.joint));
  };
  const auto size =
      static_cast<Eigen::Index>(6 * joints * problem.times.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  const auto state_of = [&](const StateKey& key) {
    return problem.joints[key.joint].states[key.frame].data();
  };
  const auto add = [&](const auto& factor, const auto& keys,
                       const Robustness& robustness) {
    using Factor = std::decay_t<decltype(factor)>;
    Linearised<Factor> at;
    if (!LineariseFactor(factor, keys, state_of, &at)) {
      ADD_FAILURE() << "no image";
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
    information += robustness.information *
                   robustness.Evaluate(at.squared_norm()).first *
                   jacobian.transpose() * jacobian;
    return true;
  };
  ForEachFactor(problem, FactorWalk(), add);
  if (!problem.prior.empty()) {
    information.topLeftCorner(6 * joints, 6 * joints) +=
        problem.prior.A.transpose() * problem.prior.A;
  }
  return information.inverse();
}

TEST_F(BoneTest, FindsTheMinimumThatCeresFinds) {
  SimulatedNoise noise;
  noise.outliers = 0.1;
  noise.missing = 0.2;
  Make(4, 30, noise);
  for (const LossKind loss : {LossKind::kNone, LossKind::kGemanMcClure}) {
    PersonProblem by_ceres = problem_;
    PersonProblem own = problem_;
    const SolveSchedule schedule = Exact(loss);
    EXPECT_TRUE(SolveWithCeres(schedule, &by_ceres).finite);
    BoneSolver solver;
    EXPECT_TRUE(solver.Solve(schedule, &own).finite);
    // The tolerances are explained in chain_solver_test.cc.
    ExpectSameStates(own, by_ceres, 3e-7);
    PersonProblem from_ours = own;
    SolveSchedule last = schedule;
    last.stages.erase(last.stages.begin());
    SolveWithCeres(last, &from_ours);
    ExpectSameStates(own, from_ours, 1e-8);
  }
}

// What decides whether Ceres needs a step.
TEST_F(BoneTest, TheStepThatIsLeftIsZeroAtTheMinimumAlone) {
  Make(4, 30, SimulatedNoise());
  const SolveSchedule schedule = Exact(LossKind::kNone);
  const SolveStage& last = schedule.stages.back();
  BoneSolver solver;
  ASSERT_TRUE(solver.Solve(schedule, &problem_).converged);
  // Its own tolerance is 1e-11 m; rounding of a gradient is a part in 1e16 of
  // terms of 1e5 / m, under a curvature of 1e3 / m^2 and more.
  EXPECT_LT(solver.SizeOfStep(problem_, last).length_m, 1e-10);
  EXPECT_TRUE(solver.IsAtMinimum(problem_, last, 3e-5));
  // One position is moved: the step that is asked for leads back, but for the
  // hundredth at which conjugate gradients stop and what is not linear in it.
  PersonProblem moved = problem_;
  moved.joints[1].states[15].x() += 1e-3;
  const BoneSolver::StepSize step = solver.SizeOfStep(moved, last);
  EXPECT_NEAR(step.length_m, 1e-3, 2e-4);
  EXPECT_FALSE(solver.IsAtMinimum(moved, last, 3e-5));
  // Its square is twice the cost that the step takes away: at the minimum the
  // cost is quadratic.
  SolveSchedule alone = schedule;
  alone.stages.assign(1, last);
  const double decrease = SolveWithCeres(alone, &moved).cost_decrease;
  EXPECT_NEAR(0.5 * step.decrement * step.decrement, decrease, 0.05 * decrease);
}

TEST_F(BoneTest, CovariancesAreBlocksOfTheDenseInverse) {
  // More frames than one stretch of factors holds.
  Make(3, 70, SimulatedNoise());
  BoneSolver solver;
  solver.Solve(Exact(LossKind::kNone), &problem_);
  std::vector<std::vector<Matrix6d>> covariances;
  ASSERT_TRUE(PersonCovariances(problem_, 1.0, 70, &covariances));
  const Eigen::MatrixXd dense = DenseCovariance(problem_);
  for (size_t j = 0; j < 3; ++j) {
    for (size_t k = 0; k < 70; ++k) {
      const Eigen::Index at = 6 * (3 * k + j);
      const Matrix6d expected = dense.block<6, 6>(at, at);
      EXPECT_LT((covariances[j][k] - expected).norm(), 1e-7 * expected.norm())
          << j << " " << k;
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
  SolveWithCeres(schedule, &by_ceres);
  ExpectSameStates(by_ceres, rest, 1e-8);
}

// A joint that nobody sees for long leaves little beside what it is taken from:
// the motion's information between two frames.
TEST_F(BoneTest, MarginalisingKeepsAJointThatNobodySees) {
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
  // Of white noise q on acceleration two frames dt apart share 12 / (q dt^3),
  // and after T without a view 3 / (q T^3) is left of a position. A sum of 18
  // products keeps 18 units of rounding of the former each frame: of 200 frames
  // at 25 Hz at most 200 * 18 * 2.2e-16 * 4 * 200^3 = 3e-5 of the latter.
  for (size_t j = 0; j < after.size(); ++j) {
    const Matrix6d& expected = before[j][kFrames - 1];
    EXPECT_LT((after[j][0] - expected).norm(), 3e-5 * expected.norm()) << j;
  }
}

// What is stated knows the loss' correction also for frames that are gone.
TEST_F(BoneTest, MarginalisingKeepsStatedCovariances) {
  constexpr size_t kFrames = 10;
  constexpr double kCorrection = 1.3;
  Make(3, kFrames, SimulatedNoise());
  BoneSolver solver;
  solver.Solve(Exact(LossKind::kGemanMcClure), &problem_);
  std::vector<std::vector<Matrix6d>> before;
  ASSERT_TRUE(PersonCovariances(problem_, kCorrection, kFrames, &before));
  PersonProblem rest = problem_;
  for (size_t dropped = 1; dropped <= 3; ++dropped) {
    DropFirstFrame(kCorrection, &rest);
    std::vector<std::vector<Matrix6d>> after;
    ASSERT_TRUE(
        PersonCovariances(rest, kCorrection, kFrames - dropped, &after));
    for (size_t j = 0; j < after.size(); ++j) {
      for (size_t k = 0; k < after[j].size(); ++k) {
        const Matrix6d& expected = before[j][k + dropped];
        // Squaring rows loses half of the sixteen digits; the information of
        // positions over that of velocities is below 1e3.
        EXPECT_LT((after[j][k] - expected).norm(), 1e-6 * expected.norm())
            << dropped << " " << j << " " << k;
      }
    }
  }
}

// Bones steady both estimators: lengths vary less, and errors shrink.
TEST_F(BoneTest, EstimatorsGainFromBones) {
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
      const auto estimator = batch ? MakeBatchEstimator(scene_, options)
                                   : MakeWindowEstimator(scene_, options);
      const auto finals = testing::Run(estimator.get(), recording_.frames);
      rmse_m[bones] = testing::RootMeanSquare(recording_.truth, finals, 100);
      double sum = 0.0;
      double squares = 0.0;
      double count = 0.0;
      for (size_t k = 100; k < finals.size(); ++k) {
        const PersonPose& person = finals[k].person;
        if (!person.joints[0].present() || !person.joints[1].present()) {
          continue;
        }
        EXPECT_TRUE(person.covariances[0].has_value());
        const double length =
            (person.joints[0].position_m - person.joints[1].position_m).norm();
        sum += length;
        squares += length * length;
        count += 1.0;
      }
      spread_m[bones] =
          std::sqrt(squares / count - sum / count * (sum / count));
    }
    EXPECT_LT(rmse_m[1], rmse_m[0]);
    EXPECT_LT(spread_m[1], 0.7 * spread_m[0]);
  }
}

}  // namespace
}  // namespace kinegraph
