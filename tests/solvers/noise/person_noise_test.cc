#include "solvers/noise/person_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "solvers/batch/batch_estimator.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/graph/assembler.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

using testing::SimulatedNoise;
using testing::SimulatedRecording;

class PersonNoiseTest : public ::testing::Test {
 protected:
  void SetUp() override {
    scene_ = testing::SmallScene(testing::RingOfCameras(4, 5.0, 1250.0), 60.0);
  }

  // A recording of 20 s whose motion is drawn from the prior.
  SimulatedRecording RecordingFromPrior(const SimulatedNoise& noise,
                                        double process_noise) {
    GraphOptions drawn = testing::FixedNoise();
    drawn.process_noise.fill(process_noise);
    // Slow enough to stay in front of the cameras for 20 s.
    drawn.birth_velocity_sigma_mps = 0.02;
    drawn.birth_position_sigma_m = 0.3;
    Random random(11);
    return testing::Simulate(
        scene_, drawn,
        testing::MotionFromPrior(scene_, drawn, Eigen::Vector3d::Zero(), 1200,
                                 &random),
        noise, Eigen::Vector3d::Zero(), &random);
  }

  // Detections of the motion `truth` by a detector with `sigma_scale` times the
  // modelled error.
  SimulatedRecording See(const std::vector<std::vector<State>>& truth,
                         double sigma_scale, uint64_t seed) const {
    SimulatedNoise noise;
    noise.sigma_scale = sigma_scale;
    return testing::Simulate(scene_, testing::FixedNoise(), truth, noise, seed);
  }

  // Learns the noise of a whole recording and applies it.
  LearntNoise LearnWhole(const std::vector<EstimatorFrame>& frames) {
    problem_ = testing::Assemble(scene_, options_, frames);
    PersonNoise noise(scene_, options_);
    noise.LearnRecording(problem_);
    noise.Apply(&problem_);
    return noise.Learnt();
  }

  // Learns the noise of a whole recording or, if `causal`, frame by frame.
  LearntNoise Learn(const SimulatedRecording& recording, bool causal) {
    if (!causal) return LearnWhole(recording.frames);
    Assembler assembler(scene_, options_);
    problem_ = {};
    PersonNoise noise(scene_, options_);
    for (size_t k = 0; k < recording.frames.size(); ++k) {
      assembler.Append(recording.frames[k], &problem_);
      noise.AddFrame(problem_, k, PersonNoise::Refit::kNow);
    }
    noise.Apply(&problem_);
    return noise.Learnt();
  }

  SceneModel scene_;
  GraphOptions options_;
  PersonProblem problem_;  // from which the noise was learnt
};

TEST_F(PersonNoiseTest, EstimatesTheSimulatedNoise) {
  SimulatedNoise noise;
  // 3 px instead of the options' 6, at the reference scale of sigma_px: 250 px
  // per metre, as here at 5 m.
  noise.sigma_scale = 0.5;
  noise.correlation_time_s = 0.1;
  noise.outliers = 0.03;
  noise.missing = 0.05;
  constexpr double kProcessNoise = 2e-4;  // slow, so it stays in the room
  const SimulatedRecording recording = RecordingFromPrior(noise, kProcessNoise);
  const auto elbow = static_cast<size_t>(JointClass::kElbow);
  for (const bool causal : {false, true}) {
    const LearntNoise learnt = Learn(recording, causal);
    const LearntNoise::OfClass& of_class = learnt.classes[elbow];
    EXPECT_EQ(of_class.joints_seen, 1200);
    // 20 s of errors with a correlation time of 0.1 s have 100 independent
    // values of five coordinates, so the 0.3 quantile is accurate to 5 % of
    // sigma (as in pixel_noise_test.cc), with three classes shrunk to their
    // common scale; 11 % of the joints have an outlier in one of four views,
    // which increases sigma by 4 %.
    EXPECT_NEAR(of_class.sigma_px, 3.0, 0.5) << causal;
    EXPECT_NEAR(learnt.correlation.time_s, 0.1, 0.04) << causal;
    EXPECT_GT(learnt.correlation.share, 0.8) << causal;
    // The simulated process noise is far below that of people, so the level of
    // the recording is at its lower limit, a tenth of the typical power.
    EXPECT_NEAR(of_class.process_noise,
                0.1 * UsualProcessNoise(JointClass::kElbow), 1e-9)
        << causal;
  }
  const LearntNoise learnt = Learn(recording, false);
  EXPECT_EQ(learnt.classes[static_cast<size_t>(JointClass::kKnee)].joints_seen,
            0);
}

TEST_F(PersonNoiseTest, PixelAndProcessNoiseCanBeFixedSeparately) {
  const SimulatedRecording recording =
      RecordingFromPrior(SimulatedNoise(), 2e-4);
  const JointChain given =
      testing::Assemble(scene_, options_, recording.frames).joints[1];
  options_.pixel_noise_from = NoiseFrom::kFixed;
  LearnWhole(recording.frames);
  const JointChain& learnt = problem_.joints[1];
  for (size_t m = 0; m < given.measurements.size(); ++m) {
    ASSERT_EQ(learnt.measurements[m].sigma_px, given.measurements[m].sigma_px);
    ASSERT_EQ(learnt.measurements[m].information,
              given.measurements[m].information);
  }
  EXPECT_NE(learnt.process_noise, given.process_noise);
  options_.pixel_noise_from = NoiseFrom::kRecording;
  options_.process_noise_from = NoiseFrom::kFixed;
  LearnWhole(recording.frames);
  EXPECT_EQ(problem_.joints[1].process_noise, given.process_noise);
  EXPECT_NE(problem_.joints[1].measurements[0].sigma_px,
            given.measurements[0].sigma_px);
}

// The noise model assumes informative confidences, but the detector's errors do
// not depend on them.
TEST_F(PersonNoiseTest, DetectsUninformativeConfidences) {
  GraphOptions without = testing::FixedNoise();
  without.confidence_power = 0.0;
  SimulatedNoise noise;
  noise.confidence_low = 0.05;
  const SimulatedRecording recording = testing::Simulate(
      scene_, without, testing::WalkingMotion(scene_, 300), noise, 5);
  for (const bool causal : {false, true}) {
    SCOPED_TRACE(causal);
    const LearntNoise learnt = Learn(recording, causal);
    EXPECT_EQ(learnt.confidence_power, 0.0);
    // The ratio of the greatest to the least sigma would be 20^p. What remains
    // is the ratio of the person's distances from the cameras (4 to 6 m), at
    // most 1.5.
    const auto [least, greatest] = std::minmax_element(
        problem_.joints[0].measurements.begin(),
        problem_.joints[0].measurements.end(),
        [](const PixelMeasurement& a, const PixelMeasurement& b) {
          return a.sigma_px < b.sigma_px;
        });
    EXPECT_LT(greatest->sigma_px / least->sigma_px, 1.6);
    // The true noise is 6 px at any confidence; the estimate is accurate to
    // 5 %, half of the tolerance.
    EXPECT_NEAR(
        learnt.classes[static_cast<size_t>(JointClass::kWrist)].sigma_px, 6.0,
        0.6);
  }
}

// After a long rest all joints are accelerated by 50 m/s^2 for 0.1 s, coast and
// are stopped in the same way. All four views agree at all times.
TEST_F(PersonNoiseTest, FollowsAgreeingViewsAfterALongRest) {
  constexpr int kFrames = 720;
  std::vector<std::vector<State>> truth(3);
  for (size_t j = 0; j < 3; ++j) {
    State state = State::Zero();
    state[2] = 0.2 * static_cast<double>(j);
    for (int k = 0; k < kFrames; ++k) {
      truth[j].push_back(state);
      const double t = k / 60.0;
      double acceleration = 0.0;
      if (t >= 10.0 && t < 10.1) acceleration = 50.0;
      if (t >= 10.25 && t < 10.35) acceleration = -50.0;
      state[0] += state[3] / 60.0 + 0.5 * acceleration / 3600.0;
      state[3] += acceleration / 60.0;
    }
  }
  const SimulatedRecording recording = See(truth, 1.0 / 3.0, 12);  // 2 px: 8 mm
  const auto worst = [&](const GraphOptions& options, bool batch) {
    const auto estimator = testing::MakeEstimator(batch, scene_, options);
    const auto finals = testing::Run(estimator.get(), recording.frames);
    double largest = 0.0;
    for (size_t k = 0; k < finals.size(); ++k) {
      for (size_t j = 0; j < 3; ++j) {
        const Joint3d& joint = finals[k].person.joints[j];
        if (!joint.present()) return 1e9;
        const double error = (joint.position_m - truth[j][k].head<3>()).norm();
        largest = std::max(largest, error);
      }
    }
    return largest;
  };
  for (const bool batch : {true, false}) {
    // The triangulation of one frame is accurate to 8 mm / sqrt(2) in two
    // directions and 4 mm in the third, 9 mm in total; the largest of 2160 such
    // errors is less than four times that, 36 mm. The limit is about twice
    // this, for the onset of the acceleration, which earlier frames cannot
    // predict.
    EXPECT_LT(worst(options_, batch), 0.07) << batch;
    // For comparison, the fixed default process noise, which suits ordinary
    // motion, loses the joint.
    EXPECT_GT(worst(testing::FixedNoise(), batch), 0.15) << batch;
  }
}

// Frames after and before a frame are equally informative, so the reversed
// recording has the same process noise, reversed, up to small differences such
// as the rounding of points that only the backward filters use. A filter in one
// direction only would differ by a half.
TEST_F(PersonNoiseTest, ReversedRecordingHasTheReversedProcessNoise) {
  const SimulatedRecording recording =
      RecordingFromPrior(SimulatedNoise(), 2.0);
  const auto process_noise = [&](std::vector<EstimatorFrame> frames) {
    for (size_t k = 0; k < frames.size(); ++k) {
      frames[k].frame = recording.frames[k].frame;
      frames[k].time = recording.frames[k].time;
    }
    LearnWhole(frames);
    return problem_.joints[0].process_noise;
  };
  const std::vector<double> forwards = process_noise(recording.frames);
  std::vector<double> backwards =
      process_noise({recording.frames.rbegin(), recording.frames.rend()});
  std::reverse(backwards.begin(), backwards.end());
  ASSERT_EQ(forwards.size(), backwards.size());
  // Near its first frame, a filter has little information.
  for (size_t k = 60; k + 60 < forwards.size(); ++k) {
    EXPECT_NEAR(backwards[k] / forwards[k], 1.0, 0.1) << k;
  }
}

// The origin is far away, as in UTM coordinates.
TEST_F(PersonNoiseTest, ProcessNoiseDoesNotDependOnTheOriginOfTheWorld) {
  const std::vector<std::vector<State>> truth =
      testing::WalkingMotion(scene_, 300);
  LearnWhole(See(truth, 1.0 / 3.0, 15).frames);
  const PersonProblem near = problem_;
  const Eigen::Vector3d shift_m(448000.0, 5400000.0, 300.0);
  scene_.cameras = Edited(scene_.cameras, [&](CameraParameters* camera) {
    camera->t -= camera->R * shift_m;
  });
  std::vector<std::vector<State>> far = truth;
  for (std::vector<State>& joint : far) {
    for (State& state : joint) state.head<3>() += shift_m;
  }
  LearnWhole(See(far, 1.0 / 3.0, 15).frames);
  for (size_t j = 0; j < truth.size(); ++j) {
    ASSERT_EQ(problem_.joints[j].process_noise.size(),
              near.joints[j].process_noise.size());
    for (size_t k = 0; k < near.joints[j].process_noise.size(); ++k) {
      EXPECT_NEAR(
          problem_.joints[j].process_noise[k] / near.joints[j].process_noise[k],
          1.0, 0.05)
          << j << " " << k;
    }
  }
}

// One arm moves and the other rests: each has its own level.
TEST_F(PersonNoiseTest, RestingArmHasLessProcessNoiseThanMovingArm) {
  scene_.skeleton = Skeleton("arms", {"l_wrist", "r_wrist"}, {});
  constexpr int kFrames = 300;
  constexpr double kSwing = 2.0 * 3.14159265 * 2.0;  // rad/s
  std::vector<std::vector<State>> truth(2);
  for (int k = 0; k < kFrames; ++k) {
    State state = State::Zero();
    state[2] = 1.0;
    truth[1].push_back(state);
    state[0] = 0.3 * sin(kSwing * k / scene_.frame_rate_hz);
    truth[0].push_back(state);
  }
  LearnWhole(See(truth, 1.0 / 3.0, 14).frames);  // 2 px: 8 mm
  // An oscillation of 47 m/s^2 at 2 Hz corresponds to hundreds of times the
  // process noise of the stiffest filter, which suits a resting arm. The limit
  // is a tenth of that, because so few frames determine it only roughly.
  for (int k = 60; k < kFrames - 60; ++k) {
    ASSERT_GT(problem_.joints[0].process_noise[k],
              20.0 * problem_.joints[1].process_noise[k])
        << k;
  }
}

// With large noise one cannot tell whether a joint rests, so it is assumed to
// be as active as the person's other joints. With little noise its rest is
// evident, regardless of the other joints.
TEST_F(PersonNoiseTest, LargePixelNoiseHidesWhetherAJointRests) {
  constexpr int kFrames = 300;
  const auto least_of_shoulder = [&](bool moves, double sigma_scale) {
    std::vector<std::vector<State>> truth(3);
    for (int k = 0; k < kFrames; ++k) {
      constexpr double kSwing = 2.0 * 3.14159265 * 2.0;  // rad/s
      const double t = k / scene_.frame_rate_hz;
      for (size_t j = 0; j < 3; ++j) {
        State state = State::Zero();
        state[2] = 0.3 * static_cast<double>(j);
        if (moves) state[0] = 0.15 * static_cast<double>(j) * sin(kSwing * t);
        truth[j].push_back(state);
      }
    }
    const auto shoulder = static_cast<size_t>(JointClass::kShoulder);
    return LearnWhole(See(truth, sigma_scale, 13).frames)
        .classes[shoulder]
        .least_process_noise;
  };
  const double usual = UsualProcessNoise(JointClass::kShoulder);
  // The lowest level of a single frame, that of the stiffest filter, is a
  // fortieth of the typical power.
  const double still = usual / 40.0;
  // At 250 px per metre, 12 px are 48 mm, and 31 mm per axis of a triangulated
  // point. With process noise of 1 m^2/s^3, more than the typical power, the
  // smoother's crossover is at 2.5 Hz, up to which noise may mask motion. The
  // level is then the mean of the three classes of joints, two of which have
  // about the typical level.
  EXPECT_GT(least_of_shoulder(true, 2.0), 0.25 * usual);
  EXPECT_LT(least_of_shoulder(false, 2.0), 4.0 * still);
  // With 0.6 px, or 2.4 mm, this crossover requires only 2.5e-3 m^2/s^3, less
  // than the process noise of the stiffest filter.
  EXPECT_LT(least_of_shoulder(true, 0.1), 2.0 * still);
}

}  // namespace
}  // namespace kinegraph
