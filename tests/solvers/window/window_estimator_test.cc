#include "solvers/window/window_estimator.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "solvers/batch/batch_estimator.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

using testing::Apart;
using testing::SimulatedNoise;
using testing::SimulatedRecording;

SceneModel MakeScene(double frame_rate_hz, bool affine) {
  return testing::SmallScene(affine
                                 ? testing::RingOfCameras(5, 1e8, 2.5e10)
                                 : testing::RingOfCameras(5, 5.0, 1000.0, true),
                             frame_rate_hz);
}

// Final poses of the batch over the first `count` frames.
std::vector<FinalPose> BatchOver(const SceneModel& scene,
                                 const GraphOptions& options,
                                 const SimulatedRecording& recording,
                                 size_t count) {
  const auto batch = MakeBatchEstimator(scene, options);
  return testing::Run(batch.get(), {recording.frames.begin(),
                                    recording.frames.begin() + count});
}

GraphOptions LinearOptions() {
  GraphOptions options = testing::FixedNoise();
  options.loss = LossKind::kNone;
  options.estimate_noise_scale = false;
  options.step_tolerance_m = 1e-12;
  options.max_iterations = 5;
  // Bridges gaps of any length, so that all positions are compared.
  options.bridging_limit_s = 60.0;
  return options;
}

// Affine cameras, no robust loss, no bones: the problem is linear, and after
// every frame the window equals a batch over the frames so far.
TEST(WindowEstimator, EqualsBatchOverTheFramesSoFarInAnAffineWorld) {
  const SceneModel scene = MakeScene(25.0, true);
  for (const double lag_s : {0.0, 0.12, 0.4}) {
    GraphOptions options = LinearOptions();
    options.lag_s = lag_s;
    SimulatedNoise noise;
    noise.missing = 0.3;
    SimulatedRecording recording = testing::Simulate(
        scene, options, testing::WalkingMotion(scene, 40), noise, 31);
    // A gap in all views and a dropped frame.
    for (size_t k = 10; k < 16; ++k) recording.frames[k].views.clear();
    recording.frames.erase(recording.frames.begin() + 25);
    recording.keypoints.erase(recording.keypoints.begin() + 25);
    recording.Connect();

    const auto window = MakeWindowEstimator(scene, options);
    size_t next = 0;
    for (size_t k = 0; k < recording.frames.size(); ++k) {
      window->Add(recording.frames[k]);
      const std::vector<FinalPose> batch =
          BatchOver(scene, options, recording, k + 1);
      // The newest pose.
      if (!recording.frames[k].views.empty()) {
        ASSERT_EQ(window->LastTime(), recording.frames[k].time);
        for (size_t j = 0; j < 3; ++j) {
          const Joint3d& joint = batch[k].person.joints[j];
          EXPECT_EQ(window->Last()[j].status, joint.status);
          if (!joint.present()) continue;
          // Cameras at 1e8 m project without a relevant rounding error; the
          // system has a condition number of 1e7, so its error is 1e-16 * 1e7.
          // The tolerance is ten times that.
          EXPECT_LT(Apart(window->Last()[j], joint), 1e-8);
        }
      }
      // Poses that became final with this frame.
      std::vector<FinalPose> finals;
      window->ExtractFinals(&finals);
      for (const FinalPose& final : finals) {
        const FinalPose& expected = batch[next++];
        EXPECT_EQ(final.frame, expected.frame);
        for (size_t j = 0; j < 3; ++j) {
          EXPECT_EQ(final.person.joints[j].status,
                    expected.person.joints[j].status);
          if (!expected.person.joints[j].present()) continue;
          EXPECT_LT(Apart(final.person.joints[j], expected.person.joints[j]),
                    1e-8);
          const Eigen::Matrix3d& covariance = *final.person.covariances[j];
          const Eigen::Matrix3d& reference = *expected.person.covariances[j];
          EXPECT_LT((covariance - reference).norm(), 1e-8);
          EXPECT_LT((covariance - reference).norm(), 1e-6 * reference.norm());
        }
      }
      const auto lag_frames = static_cast<size_t>(lag_s * 25.0 + 0.5);
      if (k < 20) {
        EXPECT_EQ(next, k < lag_frames ? 0 : k - lag_frames + 1);
      }
    }
    window->Finish();
    std::vector<FinalPose> rest;
    window->ExtractFinals(&rest);
    EXPECT_EQ(next + rest.size(), recording.frames.size());
  }
}

TEST(WindowEstimator, RobustWindowStaysCloseToBatch) {
  const SceneModel scene = MakeScene(25.0, false);
  GraphOptions options = testing::FixedNoise();
  options.estimate_noise_scale = false;
  SimulatedNoise noise;
  noise.outliers = 0.1;
  noise.outlier_burst = 5;
  const SimulatedRecording recording = testing::Simulate(
      scene, options, testing::WalkingMotion(scene, 200), noise, 32);
  const auto window = MakeWindowEstimator(scene, options);
  const auto finals = testing::Run(window.get(), recording.frames);
  const auto batch =
      BatchOver(scene, options, recording, recording.frames.size());
  ASSERT_EQ(finals.size(), batch.size());
  std::vector<double> distances;
  for (size_t k = 0; k < batch.size(); ++k) {
    for (size_t j = 0; j < 3; ++j) {
      if (batch[k].person.joints[j].status != JointStatus::kObserved) continue;
      distances.push_back(
          Apart(batch[k].person.joints[j], finals[k].person.joints[j]));
    }
  }
  std::sort(distances.begin(), distances.end());
  // Required accuracy at a lag of ten frames.
  EXPECT_LT(distances[distances.size() / 2], 0.2e-3);
  EXPECT_LT(distances[distances.size() * 95 / 100], 4e-3);
}

TEST(WindowEstimator, LastAndPredictAreCausal) {
  const SceneModel scene = MakeScene(25.0, false);
  GraphOptions options = testing::FixedNoise();
  SimulatedRecording recording = testing::Simulate(
      scene, options, testing::WalkingMotion(scene, 60), SimulatedNoise(), 33);
  for (size_t k = 50; k < 60; ++k) recording.frames[k].views.clear();
  const auto window = MakeWindowEstimator(scene, options);
  EXPECT_TRUE(window->Last().empty());
  for (size_t k = 0; k < 60; ++k) {
    window->Add(recording.frames[k]);
    const size_t seen = std::min<size_t>(k, 49);
    EXPECT_EQ(window->LastTime(), recording.frames[seen].time);
    if (k < 10) continue;
    for (size_t j = 0; j < 3; ++j) {
      // sigma_px, 6 px at 4 m and a focal length of 1000 px, is 24 mm per view
      // and axis at any depth; five views and time average it.
      EXPECT_LT(Apart(window->Last()[j], recording.truth[j][seen]), 0.08);
    }
  }
  Pose3d pose;
  window->Predict(recording.frames[52].time, &pose);
  for (size_t j = 0; j < 3; ++j) {
    EXPECT_EQ(pose[j].status, JointStatus::kInferred);
    // Prediction over three frames; the velocity is known to about 0.5 m/s.
    EXPECT_LT(Apart(pose[j], recording.truth[j][52]), 0.2);
  }
}

TEST(WindowEstimator, JointsNeverSeenAreMissing) {
  const SceneModel scene = MakeScene(25.0, false);
  GraphOptions options = testing::FixedNoise();
  SimulatedRecording recording = testing::Simulate(
      scene, options, testing::WalkingMotion(scene, 60), SimulatedNoise(), 34);
  for (size_t k = 0; k < 60; ++k) {
    for (size_t c = 0; c < 5; ++c) {
      recording.keypoints[k][c][0].found = false;              // never
      if (c > 0) recording.keypoints[k][c][1].found = false;   // one view only
      if (k < 30) recording.keypoints[k][c][2].found = false;  // at first
    }
    recording.frames[k].initial[0].status = JointStatus::kMissing;
    recording.frames[k].initial[1].status = JointStatus::kMissing;
    if (k < 30) recording.frames[k].initial[2].status = JointStatus::kMissing;
  }
  recording.Connect();
  const auto window = MakeWindowEstimator(scene, options);
  const auto finals = testing::Run(window.get(), recording.frames);
  ASSERT_EQ(finals.size(), 60u);
  for (size_t k = 0; k < 60; ++k) {
    EXPECT_EQ(finals[k].person.joints[0].status, JointStatus::kMissing);
    EXPECT_EQ(finals[k].person.joints[1].status, JointStatus::kMissing);
    EXPECT_FALSE(finals[k].person.covariances[0].has_value());
  }
  EXPECT_EQ(finals[10].person.joints[2].status, JointStatus::kMissing);
  // The lag lets the window infer the joint shortly before its first detection.
  EXPECT_EQ(finals[25].person.joints[2].status, JointStatus::kInferred);
  EXPECT_EQ(finals[45].person.joints[2].status, JointStatus::kObserved);
  EXPECT_LT(Apart(finals[45].person.joints[2], recording.truth[2][45]), 0.08);
}

// At high frame rates several frames share a solve, and no frame waits for
// longer than the lag.
TEST(WindowEstimator, HighFrameRatesShareSolves) {
  constexpr size_t kFrames = 240;
  const SceneModel scene = MakeScene(240.0, false);
  GraphOptions options;
  options.solver = GraphSolver::kBlockTridiagonal;
  options.lag_s = 0.1;
  options.ledger = std::make_shared<SolveLedger>();
  const SimulatedRecording recording =
      testing::Simulate(scene, options, testing::WalkingMotion(scene, kFrames),
                        SimulatedNoise(), 36);
  const auto window = MakeWindowEstimator(scene, options);
  std::vector<FinalPose> finals;
  for (const EstimatorFrame& frame : recording.frames) {
    window->Add(frame);
    window->ExtractFinals(&finals);
    const size_t oldest = finals.size();
    ASSERT_LT(oldest, recording.frames.size());
    EXPECT_LT(ToSeconds(frame.time - recording.frames[oldest].time),
              options.lag_s - 5e-4);
    EXPECT_LE(ToSeconds(frame.time - window->LastTime()), 3.1 / 240.0);
  }
  window->Finish();
  window->ExtractFinals(&finals);
  ASSERT_EQ(finals.size(), kFrames);
  // The first frame, every fourth frame after it, and the rest in Finish(), for
  // each of three joints.
  EXPECT_EQ(options.ledger->Total().solves, 3 * 61);
  // Fewer solves do not reduce the accuracy: the error stays below that of a
  // single frame's triangulation from five views, 24 mm / sqrt(5 / 2) = 15 mm
  // per horizontal axis (24 mm as in LastAndPredictAreCausal).
  EXPECT_LT(testing::RootMeanSquare(recording.truth, finals, 24), 0.015);
}

// If frames are absent, solves follow the time, not the number of frames.
TEST(WindowEstimator, AbsentFramesDoNotDelaySolves) {
  const SceneModel scene = MakeScene(240.0, false);
  GraphOptions options;
  options.solver = GraphSolver::kBlockTridiagonal;
  options.lag_s = 0.1;
  const SimulatedRecording recording = testing::Simulate(
      scene, options, testing::WalkingMotion(scene, 240), SimulatedNoise(), 38);
  const auto window = MakeWindowEstimator(scene, options);
  std::vector<FinalPose> finals;
  for (size_t k = 0; k < 240; k += 4) {
    const EstimatorFrame& frame = recording.frames[k];
    window->Add(frame);
    EXPECT_EQ(window->LastTime(), frame.time) << k;
    window->ExtractFinals(&finals);
    const TimeNs oldest = recording.frames[4 * finals.size()].time;
    EXPECT_LT(ToSeconds(frame.time - oldest), options.lag_s - 5e-4) << k;
  }
}

// Every second frame has views: even frames before frame 60, odd frames from
// then on. Solves take place at every second frame, so that either before frame
// 60 or after it they end in frames without views.
TEST(WindowEstimator, LastIsTheNewestMeasuredFrameOfASharedSolve) {
  const SceneModel scene = MakeScene(120.0, false);
  GraphOptions options;
  options.solver = GraphSolver::kBlockTridiagonal;
  SimulatedRecording recording = testing::Simulate(
      scene, options, testing::WalkingMotion(scene, 140), SimulatedNoise(), 37);
  for (size_t k = 0; k < 140; ++k) {
    if (k % 2 == (k < 60 ? 1 : 0)) recording.frames[k].views.clear();
  }
  const auto window = MakeWindowEstimator(scene, options);
  for (size_t k = 0; k < 140; ++k) {
    const EstimatorFrame& frame = recording.frames[k];
    window->Add(frame);
    EXPECT_LE(ToSeconds(frame.time - window->LastTime()), 3.1 / 120.0) << k;
  }
}

}  // namespace
}  // namespace kinegraph
