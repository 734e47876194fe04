// Coverage of the reported covariances. Motion is drawn from the estimators'
// own prior, detections from their noise model; some tests add outliers,
// correlation between frames or a larger sigma.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "solvers/batch/batch_estimator.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

using testing::SimulatedNoise;
using testing::SimulatedRecording;

constexpr double kInEllipsoid = 7.815;  // 95 % of chi-square(3)

SceneModel MakeScene(double frame_rate_hz, double radius_m) {
  return testing::SmallScene(testing::RingOfCameras(5, radius_m, 1000.0),
                             frame_rate_hz);
}

// Sums over the joints of poses that were added.
struct Consistency {
  double count = 0.0;
  double nees = 0.0;      // normalised estimation error squared
  double inside = 0.0;    // number of errors within the 95 % ellipsoid
  double squared = 0.0;   // errors [m^2]
  double variance = 0.0;  // reported [m^2]
  // The following sums include bridged poses.
  double written = 0.0;
  double written_squared = 0.0;
  double rmse_m() const { return std::sqrt(written_squared / written); }

  void Add(const FinalPose& pose, size_t joint, const State& truth) {
    const Joint3d& found = pose.person.joints[joint];
    if (!found.present()) return;
    const Eigen::Vector3d error = found.position_m - truth.head<3>();
    written += 1.0;
    written_squared += error.squaredNorm();
    if (found.status != JointStatus::kObserved) return;
    const Eigen::Matrix3d& covariance = *pose.person.covariances[joint];
    const double distance = error.dot(covariance.inverse() * error);
    count += 1.0;
    nees += distance;
    inside += distance < kInEllipsoid ? 1.0 : 0.0;
    squared += error.squaredNorm();
    variance += covariance.trace();
  }
};

// Parameter: true for the batch, false for the window.
class Exactness : public ::testing::TestWithParam<bool> {};

TEST_P(Exactness, ErrorsMatchReportedCovariances) {
  const SceneModel scene = MakeScene(25.0, 8.0);
  GraphOptions options = testing::FixedNoise();
  options.loss = LossKind::kNone;
  options.estimate_noise_scale = false;
  options.correlation_time_s = 0.0;
  options.information_scale = 1.0;
  options.birth_position_sigma_m = 0.5;
  options.birth_velocity_sigma_mps = 0.5;
  SimulatedNoise noise;
  // Without initial poses, estimator and simulation use the same priors and
  // sigmas.
  noise.initial_poses = false;
  noise.confidence_low = 0.3;
  noise.missing = 0.2;
  const Eigen::Vector3d centre(0.0, 0.0, 1.0);
  constexpr int kSeeds = 500;
  constexpr size_t kFrames = 25;
  std::vector<Consistency> joints(3);
  for (int seed = 0; seed < kSeeds; ++seed) {
    Random random(seed);
    const SimulatedRecording recording = testing::Simulate(
        scene, options,
        testing::MotionFromPrior(scene, options, centre, kFrames, &random),
        noise, centre, &random);
    const auto estimator = testing::MakeEstimator(GetParam(), scene, options);
    const auto finals = testing::Run(estimator.get(), recording.frames);
    for (size_t j = 0; j < joints.size(); ++j) {
      constexpr size_t kMiddle = kFrames / 2;
      joints[j].Add(finals[kMiddle], j, recording.truth[j][kMiddle]);
    }
  }
  for (const Consistency& joint : joints) {
    // With each of five views missing with probability 0.2, at least two remain
    // in 99.3 % of the cases; a few people leave the images.
    EXPECT_GT(joint.count, 0.97 * kSeeds);
    EXPECT_GT(std::sqrt(joint.squared / joint.variance), 0.95);
    EXPECT_LT(std::sqrt(joint.squared / joint.variance), 1.05);
    // The mean of n chi-squares with 3 degrees of freedom has the standard
    // error sqrt(6 / n). Three standard errors are exceeded by chance in 0.3 %
    // of the cases, for each of the three joints.
    EXPECT_NEAR(joint.nees / joint.count, 3.0,
                3.0 * std::sqrt(6.0 / joint.count));
  }
}

INSTANTIATE_TEST_SUITE_P(Estimators, Exactness, ::testing::Bool());

// Sums over all poses in the middle half of several recordings of 1.6 s.
Consistency Measure(bool batch, const GraphOptions& options,
                    const SimulatedNoise& noise, double frame_rate_hz,
                    int recordings) {
  const SceneModel scene = MakeScene(frame_rate_hz, 6.0);
  GraphOptions motion = options;  // people start near the middle, slowly
  motion.birth_position_sigma_m = 0.3;
  motion.birth_velocity_sigma_mps = 0.5;
  const auto frame_count = static_cast<size_t>(1.6 * frame_rate_hz);
  const Eigen::Vector3d centre(0.0, 0.0, 1.0);
  Consistency all;
  for (int seed = 0; seed < recordings; ++seed) {
    Random random(7000 + seed);
    const SimulatedRecording recording = testing::Simulate(
        scene, options,
        testing::MotionFromPrior(scene, motion, centre,
                                 static_cast<int>(frame_count), &random),
        noise, centre, &random);
    const auto estimator = testing::MakeEstimator(batch, scene, options);
    const auto finals = testing::Run(estimator.get(), recording.frames);
    for (size_t j = 0; j < recording.truth.size(); ++j) {
      for (size_t k = frame_count / 4; k < 3 * frame_count / 4; ++k) {
        all.Add(finals[k], j, recording.truth[j][k]);
      }
    }
  }
  return all;
}

class Defaults : public ::testing::TestWithParam<bool> {};

// Two cases: the default loss with white noise, where J'WJ alone underestimates
// the information and the correction compensates; and the default
// options, except for fixed noise, with realistic detections.
TEST_P(Defaults, EllipsoidsContainNinetyFivePerCentOfTheErrors) {
  GraphOptions white = testing::FixedNoise();
  white.correlation_time_s = 0.0;
  white.information_scale = 1.0;
  SimulatedNoise detector;
  detector.correlation_time_s = 0.1;
  detector.confidence_low = 0.3;
  detector.missing = 0.1;
  detector.outliers = 0.03;
  detector.outlier_burst = 3;
  for (const auto& result :
       {Measure(GetParam(), white, SimulatedNoise(), 25.0, 100),
        Measure(GetParam(), testing::FixedNoise(), detector, 25.0, 100)}) {
    EXPECT_GT(result.inside / result.count, 0.93);
    EXPECT_LT(result.inside / result.count, 0.97);
  }
}

TEST_P(Defaults, CovariancesAreConsistentAtAnyFrameRate) {
  const GraphOptions options = testing::FixedNoise();
  SimulatedNoise noise;
  noise.correlation_time_s = 0.1;  // correlation of 0.67 per frame at 25 Hz
  for (const double frame_rate_hz : {25.0, 60.0, 120.0}) {
    const Consistency result =
        Measure(GetParam(), options, noise, frame_rate_hz, 15);
    EXPECT_GT(result.nees / result.count / 3.0, 0.7) << frame_rate_hz;
    EXPECT_LT(result.nees / result.count / 3.0, 1.5) << frame_rate_hz;
  }
}

TEST_P(Defaults, GrossOutliersCostLittle) {
  const GraphOptions options = testing::FixedNoise();
  SimulatedNoise noise;
  noise.correlation_time_s = 0.1;
  const double clean_m = Measure(GetParam(), options, noise, 25.0, 60).rmse_m();
  noise.outliers = 0.1;
  for (const int burst : {1, 5}) {
    noise.outlier_burst = burst;
    EXPECT_LT(Measure(GetParam(), options, noise, 25.0, 60).rmse_m(),
              1.3 * clean_m)
        << burst;
  }
}

INSTANTIATE_TEST_SUITE_P(Estimators, Defaults, ::testing::Bool());

TEST(NoiseScale, IsEstimatedFromTheResiduals) {
  // The detector's error is twice the configured one; the batch's covariances
  // nevertheless match its errors.
  GraphOptions options = testing::FixedNoise();
  options.correlation_time_s = 0.0;
  options.information_scale = 1.0;
  SimulatedNoise noise;
  noise.sigma_scale = 2.0;
  noise.outliers = 0.05;
  const Consistency result = Measure(/*batch=*/true, options, noise, 25.0, 60);
  EXPECT_NEAR(std::sqrt(result.squared / result.variance), 1.0, 0.1);
}

}  // namespace
}  // namespace kinegraph
