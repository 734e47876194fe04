#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/base/random.h"
#include "solvers/noise/information.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

constexpr double kFrameS = 0.01;
constexpr double kVarianceM2 = 1e-4;
// The crossover is at 20 rad/s with white errors.
constexpr double kCrossover = 20.0;
const double kLagProcessNoise = kVarianceM2 * kFrameS * std::pow(kCrossover, 4);
constexpr int kLagFrames = 6000;

// Points of `motion`, called once a frame, with errors of that correlation.
LagLearner::Ratios RatiosOf(const std::function<Vector3d(double)>& motion,
                            const ErrorCorrelation& correlation,
                            int frames = kLagFrames, double off = 1.0) {
  Random random(5);
  const auto draw = [&] {
    return Vector3d(random.Normal(), random.Normal(), random.Normal());
  };
  const double keeps = std::exp(-kFrameS / correlation.time_s);
  Vector3d lasting = draw();
  std::vector<LagSample> samples;
  for (int k = 0; k < frames; ++k) {
    LagSample sample;
    sample.time_s = k * kFrameS;
    lasting = keeps * lasting + std::sqrt(1.0 - keeps * keeps) * draw();
    sample.point_m = motion(sample.time_s) +
                     off * std::sqrt(kVarianceM2) *
                         (std::sqrt(correlation.share) * lasting +
                          std::sqrt(1.0 - correlation.share) * draw());
    // A tenth of the frames lacks a point.
    if (k % 10 == 3) {
      sample.point_m.fill(std::numeric_limits<double>::quiet_NaN());
    }
    sample.variance_m2 = kVarianceM2;
    sample.process_noise = kLagProcessNoise;
    sample.expected =
        LeftOver(correlation, kFrameS, kLagProcessNoise, kVarianceM2);
    samples.push_back(sample);
  }
  LagLearner learner;
  learner.Add(samples);
  return learner.Fit();
}

double LagOf(const std::function<Vector3d(double)>& motion,
             const ErrorCorrelation& correlation, int frames = kLagFrames) {
  return RatiosOf(motion, correlation, frames).lag;
}

// Driven by white noise on its derivative of that order, whose power crosses
// that of the errors at the crossover. Far below that it is held back, so that
// nobody leaves for the horizon.
std::function<Vector3d(double)> Driven(int order) {
  return [order, random = Random(11),
          derivatives =
              std::vector<Vector3d>(order, Vector3d::Zero())](double) mutable {
    const double power =
        kLagProcessNoise * std::pow(kCrossover, 2.0 * (order - 2));
    Vector3d carried =
        std::sqrt(power / kFrameS) *
        Vector3d(random.Normal(), random.Normal(), random.Normal());
    for (Vector3d& derivative : derivatives) {
      constexpr double kHeldBack = 2.0;  // rad/s
      derivative += kFrameS * (carried - kHeldBack * derivative);
      carried = derivative;
    }
    return carried;
  };
}

// Of 60 s some 60 * 20 / pi * 3 = 1100 values are independent: their mean
// square is known to 4 %. Frames without a point lower the crossover, which
// adds a tenth to the lag of jerk.
constexpr double kTolerance = 0.2;

TEST(MotionLagTest, WhoseMotionIsSlowDoesNotLag) {
  // Its lag, (3 / 20)^4 of 0.1 m, is less than a tenth of a millimetre.
  const auto slow = [](double time_s) {
    return Vector3d(0.1 * std::sin(2.0 * time_s), 0.1 * std::cos(3.0 * time_s),
                    1.0);
  };
  EXPECT_NEAR(LagOf(slow, {0.0, 0.1}), 0.0, kTolerance);
  // Errors that last are not taken for motion.
  EXPECT_NEAR(LagOf(slow, {0.9, 0.1}), 0.0, kTolerance);
}

TEST(MotionLagTest, WhiteJerkLagsAsThePriorSays) {
  EXPECT_NEAR(LagOf(Driven(3), {0.0, 0.1}), 1.0, kTolerance);
}

TEST(MotionLagTest, WhiteAccelerationShowsWhatLiesBelowTheCrossover) {
  // u^4 / (1 + u^4)^4 and u^2 / (1 + u^4)^4 over u: 0.0607 and 0.1302.
  EXPECT_NEAR(LagOf(Driven(2), {0.0, 0.1}), 0.466, kTolerance);
}

TEST(MotionLagTest, OfLittleThePriorStays) {
  const auto still = [](double) { return Vector3d::Zero(); };
  EXPECT_GT(LagOf(still, {0.0, 0.1}, 30), 0.7);
  EXPECT_EQ(LagLearner().Fit().lag, 1.0);
  EXPECT_EQ(LagLearner().Fit().noise, 1.0);
}

// Points that are a fifth less off than their covariances say are no lag that
// is missing.
TEST(MotionLagTest, SmallErrorsAreNoLagThatIsMissing) {
  for (const double off : {0.8, 1.0}) {
    for (const ErrorCorrelation correlation :
         {ErrorCorrelation{0.0, 0.1}, ErrorCorrelation{0.9, 0.1}}) {
      const LagLearner::Ratios ratios =
          RatiosOf(Driven(3), correlation, kLagFrames, off);
      // Of lasting errors little is left above the crossover.
      EXPECT_NEAR(ratios.noise, off * off, 0.15 * off * off);
      EXPECT_NEAR(ratios.lag, LagOf(Driven(3), correlation), kTolerance);
    }
  }
}

}  // namespace
}  // namespace kinegraph
