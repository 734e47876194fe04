#include "solvers/noise/information.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/base/random.h"

namespace kinegraph {
namespace {

constexpr double kFrame_s = 1.0 / 30.0;

TEST(InformationTest, WhiteErrorsKeepTheInformation) {
  const ErrorCorrelation white{0.0, 0.1};
  EXPECT_EQ(InformationDivisor(white, kFrame_s, 1.0, 1e-4), 1.0);
  EXPECT_EQ(CovarianceFactor(white, kFrame_s, 1.0, 1e-4), 1.0);
}

TEST(InformationTest, SlowSmootherCountsCorrelatedErrorsOnce) {
  // Far below 1 / tau, (1 + phi) / (1 - phi) frames count as one.
  const ErrorCorrelation lasting{1.0, 0.1};
  const double phi = std::exp(-kFrame_s / 0.1);
  EXPECT_NEAR(InformationDivisor(lasting, kFrame_s, 1e-8, 1e-2),
              (1.0 + phi) / (1.0 - phi), 0.01);
  EXPECT_NEAR(CovarianceFactor(lasting, kFrame_s, 1e-8, 1e-2), 1.0, 0.01);
}

TEST(InformationTest, FastSmootherFollowsCorrelatedErrors) {
  const ErrorCorrelation lasting{0.9, 0.1};
  const double slow = InformationDivisor(lasting, kFrame_s, 0.1, 1e-4);
  const double fast = InformationDivisor(lasting, kFrame_s, 100.0, 1e-4);
  EXPECT_GT(slow, fast);
  EXPECT_GE(fast, 1.0);
  // Below the crossover frequency, correlated errors have more power than at
  // the crossover.
  EXPECT_GT(CovarianceFactor(lasting, kFrame_s, 10.0, 1e-4), 1.0);
}

// The integrals of CovarianceFactor over u = w / w_c with many narrow steps.
double FactorByNarrowSteps(const ErrorCorrelation& correlation, double frame_s,
                           double process_noise, double variance_m2) {
  const double divisor =
      InformationDivisor(correlation, frame_s, process_noise, variance_m2);
  const double crossover =
      std::pow(process_noise / (variance_m2 * frame_s * divisor), 0.25);
  const double phi = std::exp(-frame_s / correlation.time_s);
  constexpr int kSteps = 400000;
  constexpr double kEnd = 4.0;
  double true_power = 0.0;
  double stated_power = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double u = (i + 0.5) * kEnd / kSteps;
    const double u4 = u * u * u * u;
    const double passed = 1.0 / ((1.0 + u4) * (1.0 + u4));
    const double angle = std::min(3.14159265358979, u * crossover * frame_s);
    const double spectrum = 1.0 - correlation.share +
                            correlation.share * (1.0 - phi * phi) /
                                (1.0 + phi * phi - 2.0 * phi * std::cos(angle));
    true_power += passed * spectrum / divisor + u4 * passed;
    stated_power += passed + u4 * passed;
  }
  return true_power / stated_power;
}

TEST(InformationTest, CovarianceFactorMatchesNumericIntegration) {
  // Most of the power of correlated errors lies below 1 / tau, which ranges
  // here from about the crossover to 1/2200 of it.
  for (const double frame_s : {1.0 / 25.0, 1.0 / 240.0}) {
    for (const double time_s : {0.1, 1.0, 10.0}) {
      for (const double process_noise : {0.1, 10.0, 1000.0}) {
        const ErrorCorrelation lasting{0.2, time_s};
        const double truth =
            FactorByNarrowSteps(lasting, frame_s, process_noise, 1e-4);
        // If w_c tau is 10 to 200, only a few steps of CovarianceFactor resolve
        // the smoother's gain, 1 / (1 + u^4), below u = 4, which causes errors
        // of up to 0.7 %.
        EXPECT_NEAR(
            CovarianceFactor(lasting, frame_s, process_noise, 1e-4) / truth,
            1.0, 0.01)
            << frame_s << " " << time_s << " " << process_noise;
      }
    }
  }
}

TEST(InformationTest, TableInterpolatesTheCovarianceFactor) {
  double farthest = 0.0;
  for (const double share : {0.0, 0.3, 0.9}) {
    for (const double time_s : {0.03, 0.1, 1.0}) {
      const ErrorCorrelation correlation{share, time_s};
      CovarianceFactorTable table(correlation, kFrame_s);
      for (double ln = -30.0; ln < 45.0;
           ln += 0.37) {  // also outside the table
        const double ratio = std::exp(ln);
        farthest = std::max(farthest,
                            std::abs(table.At(ratio * 1e-4, 1e-4) /
                                         CovarianceFactor(correlation, kFrame_s,
                                                          ratio * 1e-4, 1e-4) -
                                     1.0));
      }
    }
  }
  // The error of cubic interpolation with a step of 1/8 is at most 3/128
  // (1/8)^4 = 6e-6 times the fourth derivative, which is below 1. Near the kink
  // at which the divisor reaches 1, the table is not used.
  EXPECT_LT(farthest, 1e-4);
}

TEST(InformationTest, ProcessNoiseHasTheRequestedCrossover) {
  for (const double share : {0.0, 0.9}) {
    const ErrorCorrelation correlation{share, 0.1};
    for (const double frequency_hz : {0.5, 2.5, 5.0}) {
      const double q =
          ProcessNoiseOfCrossover(correlation, kFrame_s, 1e-3, frequency_hz);
      const double divisor = InformationDivisor(correlation, kFrame_s, q, 1e-3);
      const double w = std::pow(q / (1e-3 * kFrame_s * divisor), 0.25);
      // The divisor is iterated in up to eight rounds, each of which reduces
      // the error to 0.35 or less: at 2.5 Hz to 7e-5, a quarter of which
      // remains in w.
      EXPECT_NEAR(w / (2.0 * 3.14159265358979 * frequency_hz), 1.0, 1e-4)
          << share << " " << frequency_hz;
    }
  }
}

using Eigen::Vector3d;

constexpr double kFrameS = 0.01;
constexpr double kVarianceM2 = 1e-4;
// The crossover is at 20 rad/s with white errors.
constexpr double kCrossover = 20.0;
const double kLagProcessNoise = kVarianceM2 * kFrameS * std::pow(kCrossover, 4);
constexpr int kLagFrames = 6000;

// The ratios learnt from points of `motion`, called once per frame, with errors
// of the given correlation and `off` times the stated standard deviation.
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
    // A tenth of the frames have no point.
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

// A motion driven by white noise on its derivative of the given order, whose
// power equals that of the errors at the crossover. It is high-pass filtered
// far below the crossover, so that the motion does not drift away.
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
      constexpr double kHeldBack = 2.0;  // rad/s, of the high-pass filter
      derivative += kFrameS * (carried - kHeldBack * derivative);
      carried = derivative;
    }
    return carried;
  };
}

// In 60 s about 60 * 20 / pi * 3 = 1100 values are independent, so their mean
// square is known to 4 %. Frames without a point lower the crossover, which
// increases the lag of jerk by a tenth.
constexpr double kTolerance = 0.2;

TEST(MotionLagTest, SlowMotionDoesNotLag) {
  // The lag of this motion, (3 / 20)^4 of 0.1 m, is less than a tenth of a
  // millimetre.
  const auto slow = [](double time_s) {
    return Vector3d(0.1 * std::sin(2.0 * time_s), 0.1 * std::cos(3.0 * time_s),
                    1.0);
  };
  EXPECT_NEAR(LagOf(slow, {0.0, 0.1}), 0.0, kTolerance);
  // Correlated errors are not mistaken for motion.
  EXPECT_NEAR(LagOf(slow, {0.9, 0.1}), 0.0, kTolerance);
}

TEST(MotionLagTest, WhiteJerkHasTheLagOfThePrior) {
  EXPECT_NEAR(LagOf(Driven(3), {0.0, 0.1}), 1.0, kTolerance);
}

TEST(MotionLagTest, WhiteAccelerationHasLessLagThanThePrior) {
  // The expected ratio is that of the integrals of u^4 / (1 + u^4)^4 and u^2 /
  // (1 + u^4)^4 over u, 0.0607 and 0.1302.
  EXPECT_NEAR(LagOf(Driven(2), {0.0, 0.1}), 0.466, kTolerance);
}

TEST(MotionLagTest, FewFramesKeepThePrior) {
  // Without motion, many frames reduce the lag to zero, as in the test of slow
  // motion. Of 50 frames only 20 to 29 lie 0.2 s from both ends; nine of these
  // have a point. A frame counts as 3 * 20 rad/s * 0.01 s / pi = 0.19 values,
  // so nine count n = 1.72 against the prior's 30. The expected noise is the
  // integral of u^8 / (1 + u^4)^4, 0.0434, per 0.130 of lag: its share is n / 3
  // = 0.57 values. Residuals are at least zero, and the subtracted noise is at
  // most its expectation, so the lag is at least (30 - 0.57) / (30 + 1.72) =
  // 0.928.
  const auto still = [](double) { return Vector3d::Zero(); };
  const double lag = LagOf(still, {0.0, 0.1}, 50);
  EXPECT_GT(lag, 0.92);
  EXPECT_NE(lag, 1.0) << "no frame was used";
  EXPECT_EQ(LagLearner().Fit().lag, 1.0);
  EXPECT_EQ(LagLearner().Fit().noise, 1.0);
}

// If points are a fifth more accurate than their covariances, the lag is not
// underestimated.
TEST(MotionLagTest, OverstatedCovariancesDoNotReduceTheLag) {
  for (const double off : {0.8, 1.0}) {
    for (const ErrorCorrelation correlation :
         {ErrorCorrelation{0.0, 0.1}, ErrorCorrelation{0.9, 0.1}}) {
      const LagLearner::Ratios ratios =
          RatiosOf(Driven(3), correlation, kLagFrames, off);
      // The noise is learnt from residuals above the crossover, where
      // correlated errors have little power.
      EXPECT_NEAR(ratios.noise, off * off, 0.15 * off * off);
      EXPECT_NEAR(ratios.lag, LagOf(Driven(3), correlation), kTolerance);
    }
  }
}

}  // namespace
}  // namespace kinegraph
