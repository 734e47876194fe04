// With any bad input, an estimator returns finite poses with appropriate status
// and covariance.
#include <glog/logging.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

#include "solvers/batch/batch_estimator.h"
#include "solvers/block_tridiagonal/bone_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

using testing::SimulatedNoise;
using testing::SimulatedRecording;

// Solver, and whether bones are used.
using Kind = std::tuple<GraphSolver, bool>;

GraphOptions OptionsOf(const Kind& kind) {
  GraphOptions options = testing::FixedNoise();
  std::tie(options.solver, options.bones) = kind;
  return options;
}

// Parameters: batch (true) or window, and Kind.
class Graceful : public ::testing::TestWithParam<std::tuple<bool, Kind>> {
 protected:
  void SetUp() override {
    scene_ =
        testing::SmallScene(testing::RingOfCameras(5, 5.0, 1000.0, true), 25.0);
    scene_.kept_matches = KeptMatches::kWeights;
  }

  void Make(size_t frames, const SimulatedNoise& noise = SimulatedNoise()) {
    recording_ = testing::Simulate(
        scene_, testing::FixedNoise(),
        testing::WalkingMotion(scene_, static_cast<int>(frames)), noise, 41);
  }

  std::vector<FinalPose> Run() {
    const auto& [batch, kind] = GetParam();
    const auto estimator =
        testing::MakeEstimator(batch, scene_, OptionsOf(kind));
    std::vector<FinalPose> finals =
        testing::Run(estimator.get(), recording_.frames);
    EXPECT_EQ(finals.size(), recording_.frames.size());
    for (const FinalPose& pose : finals) ExpectSound(pose.person);
    return finals;
  }

  // Finite positions, positive definite covariances where there is a position.
  static void ExpectSound(const PersonPose& person) {
    for (size_t j = 0; j < person.joints.size(); ++j) {
      if (!person.joints[j].present()) {
        EXPECT_FALSE(person.covariances[j].has_value());
        continue;
      }
      EXPECT_TRUE(person.joints[j].position_m.allFinite());
      ASSERT_TRUE(person.covariances[j].has_value());
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
          *person.covariances[j]);
      EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0);
      EXPECT_TRUE(std::isfinite(eigen.eigenvalues().maxCoeff()));
    }
    for (const ViewMatch& match : person.matches) {
      for (const auto& weight : match.weights) {
        if (weight.has_value()) {
          EXPECT_GE(*weight, 0.0);
          EXPECT_LE(*weight, 1.0);
        }
      }
    }
  }

  static int Count(const std::vector<FinalPose>& finals, JointStatus status) {
    int count = 0;
    for (const FinalPose& pose : finals) {
      for (const Joint3d& joint : pose.person.joints) {
        count += joint.status == status;
      }
    }
    return count;
  }

  void KeepCameras(int count) {
    for (EstimatorFrame& frame : recording_.frames) frame.views.resize(count);
  }

  SceneModel scene_;
  SimulatedRecording recording_;
};

TEST_P(Graceful, OneCameraLeavesAllJointsMissing) {
  Make(40);
  KeepCameras(1);
  const auto finals = Run();
  EXPECT_EQ(Count(finals, JointStatus::kMissing), 120);
}

TEST_P(Graceful, TwoCamerasSuffice) {
  Make(40);
  KeepCameras(2);
  const auto finals = Run();
  EXPECT_GT(Count(finals, JointStatus::kObserved), 100);
  EXPECT_LT(testing::RootMeanSquare(recording_.truth, finals), 0.06);
}

TEST_P(Graceful, JointsSeenOnlyInTheFirstFrameAreBridgedBriefly) {
  Make(1);
  Run();
  Make(20);
  for (size_t k = 1; k < 20; ++k) recording_.frames[k].views.clear();
  const auto finals = Run();
  // The first frame is known; half a second is bridged and no more.
  EXPECT_NE(finals[0].person.joints[0].status, JointStatus::kMissing);
  EXPECT_EQ(finals[19].person.joints[0].status, JointStatus::kMissing);
}

TEST_P(Graceful, WithoutDetectionsAllJointsAreMissing) {
  Make(20);
  for (EstimatorFrame& frame : recording_.frames) frame.views.clear();
  EXPECT_EQ(Count(Run(), JointStatus::kMissing), 60);
}

TEST_P(Graceful, FindsTheMotionWithoutInitialPoses) {
  Make(20);
  for (EstimatorFrame& frame : recording_.frames) {
    frame.has_initial = false;
    frame.initial.clear();
  }
  const auto finals = Run();
  EXPECT_LT(testing::RootMeanSquare(recording_.truth, finals), 0.1);
}

TEST_P(Graceful, AbsentPersonIsMissingExceptNearObservations) {
  Make(100);
  for (size_t k = 30; k < 70; ++k) {
    recording_.frames[k].views.clear();
    recording_.frames[k].has_initial = false;
  }
  const auto finals = Run();
  EXPECT_EQ(finals[20].person.joints[0].status, JointStatus::kObserved);
  EXPECT_EQ(finals[35].person.joints[0].status, JointStatus::kInferred);
  EXPECT_EQ(finals[50].person.joints[0].status, JointStatus::kMissing);
  // About as near to the next observation as frame 35 is to the previous one.
  EXPECT_EQ(finals[65].person.joints[0].status, JointStatus::kInferred);
  for (const size_t k : {33, 67}) {
    EXPECT_LT(
        testing::Apart(finals[k].person.joints[1], recording_.truth[1][k]), 0.1)
        << k;
  }
  EXPECT_EQ(finals[90].person.joints[0].status, JointStatus::kObserved);
  // The covariance grows away from the last observation.
  EXPECT_GT(finals[38].person.covariances[0]->trace(),
            finals[32].person.covariances[0]->trace());
  EXPECT_LT(testing::RootMeanSquare(recording_.truth, finals, 75), 0.05);
}

TEST_P(Graceful, CameraRotatedByThreeDegreesLosesItsWeight) {
  Make(80);
  const double clean_m = testing::RootMeanSquare(recording_.truth, Run());
  CameraParameters turned = scene_.cameras[1].parameters();
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(3.0 * 3.14159265 / 180.0, Eigen::Vector3d::UnitY())
          .toRotationMatrix();
  turned.R = turn * turned.R;
  turned.t = turn * turned.t;
  scene_.cameras[1] = Camera(turned);
  const auto finals = Run();
  // Four of five cameras remain, with a small influence of the fifth.
  EXPECT_LT(testing::RootMeanSquare(recording_.truth, finals), 1.5 * clean_m);
  double weight = 0.0;
  double count = 0.0;
  for (const FinalPose& pose : finals) {
    for (const auto& joint : pose.person.matches[1].weights) {
      weight += joint.value_or(0.0);
      count += joint.has_value();
    }
  }
  EXPECT_LT(weight / count, 0.25);
}

TEST_P(Graceful, OutliersAloneAreSeldomObserved) {
  SimulatedNoise noise;
  noise.outliers = 1.0;
  noise.outlier_low_px = 100.0;
  noise.outlier_high_px = 2000.0;
  Make(60, noise);
  const auto finals = Run();
  // In fewer than a third of the 180 joints do two views agree by chance.
  EXPECT_LT(Count(finals, JointStatus::kObserved), 60);
}

TEST_P(Graceful, NonFiniteAndHugeNumbersGiveSoundPoses) {
  Make(30);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  recording_.keypoints[3][0][0].px.x() = nan;
  recording_.keypoints[4][1][1].px.y() = inf;
  recording_.keypoints[5][2][2].confidence = nan;
  recording_.keypoints[6][2][2].px.x() = 1e300;
  recording_.keypoints[7][3][0].px.x() = -1e150;
  recording_.Connect();
  recording_.frames[8].initial[0].position_m.x() = nan;
  recording_.frames[9].initial[1].position_m *= 1e200;
  recording_.frames[10].initial[2].position_m =
      scene_.cameras[0].centre() * 3.0;
  Run();
}

TEST_P(Graceful, RecoversFromInitialPosesWithLargeErrors) {
  Make(60);
  Random random(42);
  for (EstimatorFrame& frame : recording_.frames) {
    for (Joint3d& joint : frame.initial) {
      joint.position_m.x() += random.Normal(0.0, 1.0);
    }
  }
  EXPECT_LT(testing::RootMeanSquare(recording_.truth, Run()), 0.05);
}

const auto kAllKinds = ::testing::Combine(
    ::testing::Values(GraphSolver::kBlockTridiagonal, GraphSolver::kCeres),
    ::testing::Bool());

std::string NameOf(const ::testing::TestParamInfo<Graceful::ParamType>& test) {
  const auto& [batch, kind] = test.param;
  return std::string(batch ? "batch_" : "window_") +
         ToString(std::get<0>(kind)) + (std::get<1>(kind) ? "_bones" : "");
}

INSTANTIATE_TEST_SUITE_P(Estimators, Graceful,
                         ::testing::Combine(::testing::Bool(), kAllKinds),
                         NameOf);

// Counts the warnings of a scope.
class WarningCounter final : public google::LogSink {
 public:
  WarningCounter() { google::AddLogSink(this); }
  ~WarningCounter() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity severity, const char*, const char*, int,
            const struct ::tm*, const char*, size_t) override {
    if (severity >= google::GLOG_WARNING) ++count_;
  }
  int count() const { return count_; }

 private:
  int count_ = 0;
};

class GracefulOptions : public ::testing::TestWithParam<Kind> {};

TEST_P(GracefulOptions, TooFewIterationsGiveFinitePosesAndOneWarning) {
  SceneModel scene =
      testing::SmallScene(testing::RingOfCameras(5, 5.0, 1000.0), 25.0);
  GraphOptions options = OptionsOf(GetParam());
  options.max_iterations = 1;
  options.loss = LossKind::kHuber;
  options.estimate_noise_scale = false;
  SimulatedRecording recording = testing::Simulate(
      scene, options, testing::WalkingMotion(scene, 30), SimulatedNoise(), 43);
  // The initial poses are wrong by a metre, so one step cannot converge.
  for (EstimatorFrame& frame : recording.frames) {
    for (Joint3d& joint : frame.initial) joint.position_m.x() += 1.0;
  }
  WarningCounter warnings;
  const auto batch = MakeBatchEstimator(scene, options);
  for (const FinalPose& pose : testing::Run(batch.get(), recording.frames)) {
    for (const Joint3d& joint : pose.person.joints) {
      EXPECT_TRUE(joint.position_m.allFinite());
      // Ceres continues after the block-tridiagonal step, and its own step
      // suffices for most joints.
      if (options.solver == GraphSolver::kBlockTridiagonal) {
        EXPECT_NE(joint.status, JointStatus::kObserved);
      }
    }
  }
  EXPECT_EQ(warnings.count(), 1);  // one line per person
}

INSTANTIATE_TEST_SUITE_P(SolversAndBones, GracefulOptions, kAllKinds);

// If a bone length contradicts the observations, one iteration does not
// suffice. The measurements of states that are still far from convergence get
// weight zero.
TEST(BoneSolverTest, ReportsNonConvergence) {
  SceneModel scene =
      testing::SmallScene(testing::RingOfCameras(5, 5.0, 1000.0), 25.0);
  GraphOptions options = testing::FixedNoise();
  options.bone_sigma_m = 1e-4;
  SimulatedRecording recording = testing::Simulate(
      scene, options, testing::WalkingMotion(scene, 20), SimulatedNoise(), 44);
  PersonProblem problem = testing::Assemble(scene, options, recording.frames);
  problem.bones.push_back({0, 1, 1.4, options.bone_sigma_m});
  SolveSchedule schedule;
  schedule.stages = {{LossKind::kHuber, 1.5, 1}};
  const SolveReport report = BoneSolver().Solve(schedule, &problem);
  EXPECT_TRUE(report.finite);
  EXPECT_FALSE(report.converged);
  EXPECT_GT(report.unsettled, 0);
  int rejected = 0;
  for (const JointChain& chain : problem.joints) {
    for (const State& state : chain.states) EXPECT_TRUE(state.allFinite());
    for (const PixelMeasurement& m : chain.measurements) {
      rejected += m.weight == 0.0;
    }
  }
  EXPECT_GT(rejected, 0);
}

}  // namespace
}  // namespace kinegraph
