// A user's own ceres::CostFunction affects window, batch, marginalisation and
// covariances.
#include "solvers/ceres/user_factor.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "solvers/batch/batch_estimator.h"
#include "solvers/block_tridiagonal/person_system.h"
#include "solvers/ceres/ceres_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/marginalise.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/simulated_person.h"
#include "tests/support/solver_problem.h"

namespace kinegraph {
namespace {

using testing::Apart;
using testing::SimulatedNoise;
using testing::SimulatedRecording;

// As in examples/own_factor.cc: a joint rests at a height above the floor.
struct FloorContact {
  template <typename T>
  bool operator()(const T* state, T* residual) const {
    residual[0] = (state[2] - height_m) / 0.005;
    for (int i = 0; i < 3; ++i) residual[i + 1] = state[i + 3] / 0.05;
    return true;
  }
  double height_m;
};

// The named joint rests in frames first .. last; `frames_back` above 1 must be
// rejected.
UserFactorSource Resting(const std::string& joint, int64_t first, int64_t last,
                         double height_m, int frames_back = 0) {
  return [=](const UserFrame& frame) {
    std::vector<UserFactor> factors;
    if (frame.frame < first || frame.frame > last) return factors;
    UserFactor& contact = factors.emplace_back();
    contact.factor =
        FromCeres(new ceres::AutoDiffCostFunction<FloorContact, 4, 6>(
            new FloorContact{height_m}));
    contact.states = {{frame.skeleton->IndexOf(joint), frames_back}};
    contact.loss = LossKind::kHuber;  // a wrong contact has limited influence
    contact.loss_scale = 3.0;
    return factors;
  };
}

class UserFactorTest : public ::testing::Test {
 protected:
  void Make(int frames) {
    scene_ = testing::SmallScene(testing::RingOfCameras(3, 5.0, 1000.0), 25.0);
    joint_ = scene_.skeleton.joints()[2];
    Random random(61);
    SimulatedNoise noise;
    noise.missing = 0.2;
    recording_ = testing::Simulate(scene_, options_,
                                   testing::WalkingMotion(scene_, frames),
                                   noise, Eigen::Vector3d::Zero(), &random);
  }

  std::vector<FinalPose> Run(bool batch, const UserFactorSource& source) {
    GraphOptions options = options_;
    options.user_factors = source;
    options.solver = GraphSolver::kCeres;
    options.max_iterations = 100;
    options.pixel_noise_from = options.process_noise_from = NoiseFrom::kFixed;
    options.estimate_noise_scale = false;
    const auto estimator = testing::MakeEstimator(batch, scene_, options);
    return testing::Run(estimator.get(), recording_.frames);
  }

  SceneModel scene_;
  GraphOptions options_;
  SimulatedRecording recording_;
  std::string joint_;
};

// The wrist of the walking person is far from the height in the factor. In both
// estimators the factor therefore affects the wrist's position and covariance,
// and no other joint.
TEST_F(UserFactorTest, WindowAndBatchUseTheFactor) {
  Make(60);
  for (const bool batch : {true, false}) {
    const auto plain = Run(batch, nullptr);
    constexpr double kHeight = 1.05;  // m
    const auto held = Run(batch, Resting(joint_, 30, 30, kHeight));
    ASSERT_EQ(plain.size(), held.size());
    const PersonPose& before = plain[30].person;
    const PersonPose& after = held[30].person;
    const auto off = [&](const PersonPose& pose) {
      return std::abs(pose.joints[2].position_m.z() - kHeight);
    };
    EXPECT_LT(off(after), off(before)) << batch;
    ASSERT_TRUE(before.covariances[2] && after.covariances[2]);
    EXPECT_LT((*after.covariances[2])(2, 2), (*before.covariances[2])(2, 2));
    // The other joints are unaffected, without bone factors. Two solves that
    // converge to steps of 3e-5 m differ by about that.
    EXPECT_LT(Apart(after.joints[0], before.joints[0]), 1e-4);
    EXPECT_NEAR((*after.covariances[0])(2, 2), (*before.covariances[0])(2, 2),
                1e-3 * (*before.covariances[0])(2, 2));
  }
}

// Without loss and bones, the window's newest state after all frames equals the
// batch's, because marginalisation keeps the factor.
TEST_F(UserFactorTest, WindowEqualsBatchAtTheEnd) {
  options_.loss = LossKind::kNone;
  Make(40);
  // At the end of the recording, the window no longer contains the contact.
  const auto source = Resting(joint_, 18, 20, 1.05);
  const auto batch = Run(true, source);
  const auto window = Run(false, source);
  const auto plain = Run(true, nullptr);
  // Linearisation points differ by millimetres at a depth of 5 m, so
  // corrections of millimetres differ by about one part in 1000.
  EXPECT_LT(
      Apart(batch.back().person.joints[2], window.back().person.joints[2]),
      2e-5);
  // The factor has an effect.
  EXPECT_GT(Apart(batch[25].person.joints[2], plain[25].person.joints[2]),
            1e-3);
}

// A chunk that begins later numbers its frames and factors from zero.
TEST_F(UserFactorTest, EveryChunkOfTheBatchUsesTheFactor) {
  Make(150);
  const auto source = Resting(joint_, 105, 105, 1.05);
  options_.chunk_s = 0.0;
  const PersonPose whole = Run(true, source)[105].person;
  const PersonPose plain = Run(true, nullptr)[105].person;
  options_.chunk_s = 2.0;  // two chunks
  const PersonPose chunk = Run(true, source)[105].person;
  // Observations a second away have almost no influence (chunks_test.cc).
  EXPECT_LT(Apart(chunk.joints[2], whole.joints[2]), 1e-4);
  EXPECT_GT(Apart(chunk.joints[2], plain.joints[2]), 1e-3);
  ASSERT_TRUE(chunk.covariances[2] && whole.covariances[2]);
  EXPECT_LT((*chunk.covariances[2] - *whole.covariances[2]).norm(),
            1e-3 * whole.covariances[2]->norm());
}

// A factor over two joints and two frames.
struct Together {
  template <typename T>
  bool operator()(const T* a, const T* b, const T* b_later, T* residual) const {
    for (int i = 0; i < 3; ++i) {
      residual[i] = (a[i] - b[i] - 0.1) / 0.05;
      residual[i + 3] = (b_later[i] - a[i] + b[i + 3] * 0.2) / 0.1;
    }
    return true;
  }
};

TEST_F(UserFactorTest, MarginalisingKeepsValuesAndCovariances) {
  constexpr size_t kFrames = 8;
  options_.user_factors = [](const UserFrame& frame) {
    std::vector<UserFactor> factors;
    if (!frame.has_previous) return factors;
    UserFactor factor;
    factor.factor = FromCeres(
        new ceres::AutoDiffCostFunction<Together, 6, 6, 6, 6>(new Together));
    factor.states = {{0, 1}, {1, 1}, {1, 0}};
    factors.push_back(factor);
    return factors;
  };
  Make(kFrames);
  PersonProblem problem =
      testing::Assemble(scene_, options_, recording_.frames);
  ASSERT_EQ(problem.user.size(), kFrames - 1);
  for (JointChain& chain : problem.joints) GateMeasurements(&chain);
  SolveSchedule schedule;
  schedule.step_tolerance_m = 1e-10;
  schedule.stages = {{LossKind::kNone, 1.0, 200}};
  ASSERT_TRUE(CeresSolver().Solve(schedule, &problem).finite);
  testing::ExpectMarginalisationKeepsCovariances(1.0, problem);
  for (size_t dropped = 1; dropped <= 3; ++dropped) {
    DropFirstFrame(1.0, &problem);
    ASSERT_EQ(problem.user.size(), kFrames - 1 - dropped);
    PersonProblem again = problem;
    CeresSolver().Solve(schedule, &again);
    // The tolerance covers rounding in a prior with a condition number of 1e7.
    testing::ExpectSameStates(again, problem, 1e-7);
  }
}

TEST_F(UserFactorTest, MisuseIsRefused) {
  Make(3);
  GraphOptions options;
  options.user_factors = Resting(joint_, 0, 9, 0.0);
  options.solver = GraphSolver::kBlockTridiagonal;
  try {
    MakeWindowEstimator(scene_, options);
    FAIL() << "the block-tridiagonal solver accepted a user's factor";
  } catch (const OptionError& error) {
    EXPECT_EQ(error.key(), "graph.solver");
  }
  EXPECT_THROW(Run(true, Resting("nobody", 0, 9, 0.0)), OptionError);
  EXPECT_THROW(Run(true, Resting(joint_, 0, 9, 0.0, 2)), OptionError);
}

}  // namespace
}  // namespace kinegraph
