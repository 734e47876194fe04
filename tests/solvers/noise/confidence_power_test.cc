#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

#include "core/base/random.h"
#include "solvers/noise/frame_points.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

constexpr double kBelieved = 0.5;

// Joints of unrelated frames in view of a ring of cameras, at 25 Hz.
struct SimulatedJoints {
  int views = 4;
  int frames = 400;
  double power = kBelieved;  // true power of the confidence
  double least_confidence = 0.1;
  double greatest_confidence = 1.0;
  double outliers = 0.0;  // fraction with an error of 100 px
};

ConfidenceWeighting Learnt(const SimulatedJoints& simulated, uint64_t seed) {
  const CameraRig cameras =
      testing::RingOfCameras(simulated.views, 5.0, 1250.0);
  ConfidenceLearner learner(kBelieved, 25.0);
  RobustTriangulationOptions options;
  options.loss = LossKind::kNone;
  const RobustTriangulator triangulator(options);
  Random random(seed);
  for (int k = 0; k < simulated.frames; ++k) {
    const Eigen::Vector3d point_m(random.Uniform(-1.0, 1.0),
                                  random.Uniform(-1.0, 1.0),
                                  random.Uniform(0.0, 2.0));
    std::vector<PixelPoint> views;
    std::vector<double> log_confidences;
    for (const Camera& camera : cameras) {
      const double confidence = random.Uniform(
          simulated.least_confidence, simulated.greatest_confidence + 1e-300);
      const double sigma_px = 3.0 * std::pow(confidence, -simulated.power);
      Eigen::Vector2d px = *camera.Project(point_m);
      px += Eigen::Vector2d(sigma_px * random.Normal(),
                            sigma_px * random.Normal());
      if (random.Chance(simulated.outliers)) px.x() += 100.0;
      // The noise model is too large by a factor of three.
      views.push_back({&camera, px, 9.0 * std::pow(confidence, -kBelieved)});
      log_confidences.push_back(std::log(confidence));
    }
    const auto solved = triangulator.TriangulateFrom(point_m, views);
    if (!solved.has_value()) continue;
    learner.Add(JointClass::kElbow, views, log_confidences, solved->position_m,
                ConfidenceWeighting());
  }
  return learner.Fit();
}

class ConfidencePowerTest
    : public ::testing::TestWithParam<std::tuple<double, int, double>> {};

// A change dp of the power changes each view's sigma by the factor exp(-dp (ln
// c - mean)), whose exponent has a standard deviation of 0.59 dp for
// confidences c uniform in 0.1 to 1. Even with a single degree of freedom for
// each of the 400 joints (four views have five), the standard deviation of the
// power is 1 / sqrt(2 * 400 * 0.59^2) = 0.06, less than half a step of the
// candidate powers (0.25, then 0.5).
TEST_P(ConfidencePowerTest, IsEstimatedFromTheErrors) {
  SimulatedJoints simulated;
  simulated.power = std::get<0>(GetParam());
  simulated.views = std::get<1>(GetParam());
  simulated.outliers = std::get<2>(GetParam());
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const double step = simulated.power < 1.0 ? 0.25 : 0.5;
    EXPECT_NEAR(kBelieved + Learnt(simulated, seed).added_power,
                simulated.power, 1.01 * step)
        << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Truths, ConfidencePowerTest,
                         ::testing::Combine(::testing::Values(0.0, 0.5, 1.0,
                                                              2.0),
                                            ::testing::Values(3, 4, 8),
                                            ::testing::Values(0.0, 0.05)));

TEST(ConfidencePower, EqualConfidencesKeepTheConfiguredPower) {
  SimulatedJoints simulated;
  simulated.power = 0.0;
  simulated.least_confidence = simulated.greatest_confidence = 0.7;
  const ConfidenceWeighting learnt = Learnt(simulated, 1);
  EXPECT_EQ(learnt.added_power, 0.0);
  EXPECT_EQ(learnt.SigmaFactor(std::log(0.3)), 1.0);
}

TEST(ConfidencePower, NoObservationsKeepTheConfiguredPower) {
  const ConfidenceLearner learner(0.6, 25.0);
  EXPECT_EQ(learner.Fit().added_power, 0.0);
}

TEST(ConfidencePower, SkipsFramesThatFollowTooSoon) {
  ConfidenceLearner fast(kBelieved, 120.0);
  int used = 0;
  for (int k = 0; k < 1200; ++k) {
    used += fast.BeginFrame(FromSeconds(k / 120.0)) ? 1 : 0;
  }
  EXPECT_EQ(used, 100);  // ten per second
  ConfidenceLearner slow(kBelieved, 5.0);
  for (int k = 0; k < 50; ++k) {
    // The clock jitters by a tenth of a millisecond.
    EXPECT_TRUE(slow.BeginFrame(FromSeconds(0.2 * k - 1e-4 * (k % 2)))) << k;
  }
}

TEST(ConfidencePower, SigmaAtTheMeanConfidenceIsUnchanged) {
  ConfidenceWeighting weighting;
  weighting.added_power = 0.5;
  weighting.mean_log = std::log(0.25);
  EXPECT_NEAR(weighting.SigmaFactor(std::log(0.25)), 1.0, 1e-15);
  EXPECT_NEAR(weighting.SigmaFactor(0.0), 0.5, 1e-15);
}

}  // namespace
}  // namespace kinegraph
