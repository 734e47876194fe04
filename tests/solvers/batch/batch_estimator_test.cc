#include "solvers/batch/batch_estimator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

using testing::SimulatedNoise;
using testing::SimulatedRecording;

class BatchEstimatorTest : public ::testing::Test {
 protected:
  void SetUp() override {
    scene_ = testing::SmallScene(testing::RingOfCameras(5, 5.0, 1000.0), 25.0);
    scene_.kept_matches = KeptMatches::kWeights;
  }

  SimulatedRecording Simulate(int frames, const SimulatedNoise& noise) {
    return testing::Simulate(scene_, options_,
                             testing::WalkingMotion(scene_, frames), noise, 81);
  }

  std::vector<FinalPose> Run(const SimulatedRecording& recording) {
    const auto batch = MakeBatchEstimator(scene_, options_);
    return testing::Run(batch.get(), recording.frames);
  }

  SceneModel scene_;
  GraphOptions options_ = testing::FixedNoise();
};

TEST_F(BatchEstimatorTest, ExactDetectionsGiveTheTruth) {
  SimulatedNoise noise;
  noise.sigma_scale = 0.0;
  options_.estimate_noise_scale = false;
  options_.sigma_px.fill(0.1);
  options_.min_sigma_px = 0.1;
  const SimulatedRecording recording = Simulate(60, noise);
  // A sigma of 0.1 px is 0.5 mm at 5 m. The remaining error is the bias of the
  // motion prior where the velocity is not constant.
  EXPECT_LT(testing::RootMeanSquare(recording.truth, Run(recording)), 0.5e-3);
}

TEST_F(BatchEstimatorTest, KeepsFramesMatchesWeightsAndScore) {
  SimulatedRecording recording = Simulate(40, SimulatedNoise());
  for (size_t k = 0; k < 40; ++k) {
    recording.frames[k].frame = 300 + static_cast<int64_t>(k);
    recording.frames[k].views[2].detection_idx = 7;
  }
  recording.keypoints[20][1][0].px.x() += 150.0;  // an outlier
  recording.keypoints[20][3][0].found = false;    // not measured
  for (auto& joint : recording.keypoints[20][4]) joint.confidence = 0.5;
  recording.Connect();
  const auto finals = Run(recording);
  ASSERT_EQ(finals.size(), 40u);
  const FinalPose& pose = finals[20];
  EXPECT_EQ(pose.frame, 320);
  EXPECT_EQ(pose.time, recording.frames[20].time);
  ASSERT_EQ(pose.person.matches.size(), 5u);
  EXPECT_EQ(pose.person.matches[2].view_idx, 2);
  EXPECT_EQ(pose.person.matches[2].detection_idx, 7);
  EXPECT_LT(*pose.person.matches[1].weights[0], 0.01);
  EXPECT_GT(*pose.person.matches[0].weights[0], 0.25);
  EXPECT_FALSE(pose.person.matches[3].weights[0].has_value());
  EXPECT_EQ(pose.person.inlier_views[0], 3);
  EXPECT_EQ(pose.person.joints[0].status, JointStatus::kObserved);
  // The five views have 14 keypoints of the three joints, three of them with
  // confidence 0.5.
  EXPECT_NEAR(pose.person.score, (11.0 + 1.5) / 14.0, 1e-12);
}

TEST_F(BatchEstimatorTest, KeepsVelocitiesOnRequest) {
  SimulatedNoise noise;
  noise.sigma_scale = 0.0;
  options_.estimate_noise_scale = false;
  options_.sigma_px.fill(0.1);
  options_.min_sigma_px = 0.1;
  const SimulatedRecording recording = Simulate(40, noise);
  for (const FinalPose& pose : Run(recording)) {
    EXPECT_TRUE(pose.person.derivatives.empty());
  }
  scene_.keep_derivatives = true;
  const auto finals = Run(recording);
  double squares = 0.0;
  double all = 0.0;
  for (size_t k = 1; k + 1 < finals.size(); ++k) {
    for (size_t j = 0; j < finals[k].person.joints.size(); ++j) {
      const Eigen::Vector3d expected =
          0.5 * scene_.frame_rate_hz *
          (finals[k + 1].person.joints[j].position_m -
           finals[k - 1].person.joints[j].position_m);
      squares += (finals[k].person.derivatives[j]->velocity_m_s - expected)
                     .squaredNorm();
      all += expected.squaredNorm();
    }
  }
  // The motion is smooth, so that the states' velocities agree with central
  // differences within a tenth.
  EXPECT_LT(std::sqrt(squares), 0.1 * std::sqrt(all));
}

TEST_F(BatchEstimatorTest, OmittingWeightsLeavesOtherResultsUnchanged) {
  const SimulatedRecording recording = Simulate(40, SimulatedNoise());
  const auto with_weights = Run(recording);
  scene_.kept_matches = KeptMatches::kDetections;
  const auto finals = Run(recording);
  ASSERT_EQ(finals.size(), with_weights.size());
  for (size_t k = 0; k < finals.size(); ++k) {
    const PersonPose& pose = finals[k].person;
    const PersonPose& other = with_weights[k].person;
    EXPECT_EQ(pose.inlier_views, other.inlier_views);
    EXPECT_EQ(pose.covariances, other.covariances);
    for (size_t j = 0; j < pose.joints.size(); ++j) {
      EXPECT_EQ(pose.joints[j].position_m, other.joints[j].position_m);
      EXPECT_EQ(pose.joints[j].status, other.joints[j].status);
    }
    ASSERT_EQ(pose.matches.size(), other.matches.size());
    for (size_t m = 0; m < pose.matches.size(); ++m) {
      EXPECT_EQ(pose.matches[m].view_idx, other.matches[m].view_idx);
      EXPECT_EQ(pose.matches[m].detection_idx, other.matches[m].detection_idx);
      EXPECT_TRUE(pose.matches[m].weights.empty());
    }
  }
}

TEST_F(BatchEstimatorTest, UsesTheClockOfEachCamera) {
  SimulatedNoise noise;
  noise.sigma_scale = 0.0;
  SimulatedRecording recording = Simulate(60, noise);
  // Camera 0 captures 20 ms late and shows the joints at that time.
  for (size_t k = 0; k < 60; ++k) {
    recording.frames[k].views[0].capture_time += 20'000'000;
    for (size_t j = 0; j < 3; ++j) {
      const State& state = recording.truth[j][k];
      recording.keypoints[k][0][j].px =
          *scene_.cameras[0].Project(state.head<3>() + 0.02 * state.tail<3>());
    }
  }
  recording.Connect();
  const double right_m =
      testing::RootMeanSquare(recording.truth, Run(recording));
  for (EstimatorFrame& frame : recording.frames) {
    frame.views[0].capture_time = frame.time;
  }
  const double wrong_m =
      testing::RootMeanSquare(recording.truth, Run(recording));
  // Detections are exact: what remains is the bias of the motion prior where
  // the velocity is not constant.
  EXPECT_LT(right_m, 4e-3);
  EXPECT_GT(wrong_m, 1.3 * right_m);
}

TEST_F(BatchEstimatorTest, ShortGapIsBridgedInEveryFrame) {
  SimulatedRecording recording = Simulate(60, SimulatedNoise());
  for (size_t k = 30; k < 40; ++k) recording.frames[k].views.clear();
  const auto finals = Run(recording);
  for (size_t k = 30; k < 40; ++k) {
    const Joint3d& joint = finals[k].person.joints[1];
    EXPECT_EQ(joint.status, JointStatus::kInferred) << k;
    EXPECT_LT(testing::Apart(joint, recording.truth[1][k]), 0.1) << k;
  }
}

// If only one view sees a joint, the length of its bone still permits two
// positions on the view's ray.
TEST_F(BatchEstimatorTest, OneViewAndABoneDoNotKeepTheCovarianceSmall) {
  constexpr size_t kWrist = 2;
  constexpr size_t kLost = 20;
  constexpr size_t kFound = 40;
  SimulatedRecording recording = Simulate(60, SimulatedNoise());
  for (size_t k = kLost; k < kFound; ++k) {
    for (size_t v = 1; v < 5; ++v)
      recording.keypoints[k][v][kWrist].found = false;
  }
  recording.Connect();
  options_.covariance = true;
  const std::vector<FinalPose> free = Run(recording);
  options_.bones = true;
  options_.bone_sigma_from = NoiseFrom::kRecording;
  const std::vector<FinalPose> held = Run(recording);
  const auto sigma_m = [](const std::vector<FinalPose>& finals, size_t k) {
    return std::sqrt(finals[k].person.covariances[kWrist]->trace());
  };
  // Two frames are less than a tenth of a second: the covariance with the bone
  // is reported.
  EXPECT_LT(sigma_m(held, kLost + 1), sigma_m(free, kLost + 1));
  // Ten frames are more: both runs report the covariance without the bone,
  // which differs only by positions and estimated pixel noise.
  EXPECT_NEAR(sigma_m(held, kLost + 10) / sigma_m(free, kLost + 10), 1.0, 0.2);
  // The elbow, which all views see, is known better than the wrist.
  EXPECT_LT(std::sqrt(held[kLost + 10].person.covariances[1]->trace()),
            0.5 * sigma_m(held, kLost + 10));
}

// Window and batch drop joints of large covariance even if covariances are not
// requested.
TEST_F(BatchEstimatorTest, OmittingCovariancesLeavesJointsUnchanged) {
  constexpr size_t kWrist = 2;
  SimulatedRecording recording = Simulate(200, SimulatedNoise());
  for (size_t k = 60; k < 160; ++k) {
    for (size_t v = 1; v < 5; ++v) {
      recording.keypoints[k][v][kWrist].found = false;
    }
  }
  recording.Connect();
  for (const bool batch : {false, true}) {
    std::vector<std::vector<FinalPose>> finals;
    for (const bool covariance : {true, false}) {
      options_.covariance = covariance;
      const auto estimator = testing::MakeEstimator(batch, scene_, options_);
      finals.push_back(testing::Run(estimator.get(), recording.frames));
      ASSERT_EQ(finals.back().size(), 200u);
    }
    int missing = 0;
    for (size_t k = 0; k < 200; ++k) {
      const PersonPose& with = finals[0][k].person;
      const PersonPose& without = finals[1][k].person;
      EXPECT_EQ(with.covariances.size(), 3u);
      EXPECT_TRUE(without.covariances.empty());
      if (!with.joints[kWrist].present()) ++missing;
      for (size_t j = 0; j < 3; ++j) {
        EXPECT_EQ(with.joints[j].status, without.joints[j].status);
        if (!with.joints[j].present()) continue;
        EXPECT_EQ(with.joints[j].position_m, without.joints[j].position_m);
      }
    }
    EXPECT_GT(missing, 0) << batch;
  }
}

TEST_F(BatchEstimatorTest, EveryLossReducesTheEffectOfOutliers) {
  SimulatedNoise noise;
  noise.outliers = 0.1;
  const SimulatedRecording recording = Simulate(80, noise);
  options_.loss = LossKind::kNone;
  const double none_m =
      testing::RootMeanSquare(recording.truth, Run(recording));
  for (const LossKind loss : {LossKind::kHuber, LossKind::kCauchy,
                              LossKind::kGemanMcClure, LossKind::kTukey}) {
    options_.loss = loss;
    EXPECT_LT(testing::RootMeanSquare(recording.truth, Run(recording)),
              0.6 * none_m);
  }
}

}  // namespace
}  // namespace kinegraph
