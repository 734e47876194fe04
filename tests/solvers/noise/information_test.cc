#include "solvers/noise/information.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kinegraph {
namespace {

constexpr double kFrame_s = 1.0 / 30.0;

TEST(InformationTest, WhiteErrorsCostNothing) {
  const ErrorCorrelation white{0.0, 0.1};
  EXPECT_EQ(InformationDivisor(white, kFrame_s, 1.0, 1e-4), 1.0);
  EXPECT_EQ(CovarianceFactor(white, kFrame_s, 1.0, 1e-4), 1.0);
}

TEST(InformationTest, ASlowSmootherSeesErrorsAsLongAsTheyAre) {
  // Far below 1 / tau all frames within it are one: (1 + phi) / (1 - phi).
  const ErrorCorrelation lasting{1.0, 0.1};
  const double phi = std::exp(-kFrame_s / 0.1);
  EXPECT_NEAR(InformationDivisor(lasting, kFrame_s, 1e-8, 1e-2),
              (1.0 + phi) / (1.0 - phi), 0.01);
  EXPECT_NEAR(CovarianceFactor(lasting, kFrame_s, 1e-8, 1e-2), 1.0, 0.01);
}

TEST(InformationTest, AFastSmootherFollowsThem) {
  const ErrorCorrelation lasting{0.9, 0.1};
  const double slow = InformationDivisor(lasting, kFrame_s, 0.1, 1e-4);
  const double fast = InformationDivisor(lasting, kFrame_s, 100.0, 1e-4);
  EXPECT_GT(slow, fast);
  EXPECT_GE(fast, 1.0);
  // Below the crossover the errors are larger than at it.
  EXPECT_GT(CovarianceFactor(lasting, kFrame_s, 10.0, 1e-4), 1.0);
}

TEST(InformationTest, ProcessNoiseHasItsCrossoverWhereItWasAsked) {
  for (const double share : {0.0, 0.9}) {
    const ErrorCorrelation correlation{share, 0.1};
    for (const double frequency_hz : {0.5, 2.5, 5.0}) {
      const double q =
          ProcessNoiseOfCrossover(correlation, kFrame_s, 1e-3, frequency_hz);
      const double divisor = InformationDivisor(correlation, kFrame_s, q, 1e-3);
      const double w = std::pow(q / (1e-3 * kFrame_s * divisor), 0.25);
      // The divisor's rounds: eight, each a quarter of the one before.
      EXPECT_NEAR(w / (2.0 * 3.14159265358979 * frequency_hz), 1.0, 1e-4)
          << share << " " << frequency_hz;
    }
  }
}

}  // namespace
}  // namespace kinegraph
