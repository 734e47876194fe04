#include "solvers/noise/pixel_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/random.h"

namespace kinegraph {
namespace {

// Residuals of four views with sigma `scale` and five degrees of freedom: five
// coordinates are noise, three are explained by the point.
TriangulationResiduals Draw(double scale, Random* random) {
  TriangulationResiduals residuals;
  residuals.views.resize(4);
  for (int i = 0; i < 5; ++i) {
    const double value = scale * random->Normal();
    residuals.square += value * value;
  }
  return residuals;
}

TEST(ChiSquareTest, QuantilesMatchPublishedTables) {
  // Published tables, and the median for two degrees of freedom in closed form.
  EXPECT_NEAR(ChiSquareQuantile(0.95, 3.0), 7.814728, 1e-6);
  EXPECT_NEAR(ChiSquareQuantile(0.5, 2.0), 2.0 * std::log(2.0), 1e-9);
  EXPECT_NEAR(ChiSquareQuantile(0.3, 1.0), 0.148472, 1e-6);
  EXPECT_NEAR(ChiSquareQuantile(0.3, 5.0), 2.999908, 1e-6);
}

TEST(NoiseScalesTest, RecoversTheScale) {
  Random random(1);
  NoiseScales scales;
  for (int i = 0; i < 2000; ++i) {
    scales.Add(JointClass::kKnee, Draw(1.7, &random));
  }
  // The 0.3 quantile of n draws has the standard error sqrt(0.21 / n) /
  // density(3.0) = 0.066, 1.1 % of sigma. The tolerance is three of these, plus
  // a margin for the priors, which have weights of 20 and 40 in 2000.
  EXPECT_NEAR(scales.Scale(JointClass::kKnee), 1.7, 1.7 * (0.033 + 0.016));
  EXPECT_EQ(scales.count(JointClass::kKnee), 2000);
}

TEST(NoiseScalesTest, OutliersHardlyMatter) {
  Random random(2);
  NoiseScales scales;
  for (int i = 0; i < 2000; ++i) {
    scales.Add(JointClass::kWrist, Draw(i % 10 == 0 ? 30.0 : 1.0, &random));
  }
  // With a tenth of large values, the 0.3 quantile is the 0.333 quantile of the
  // others: 3.21 instead of 3.00, 3.5 % of sigma. The tolerance is three
  // standard errors.
  EXPECT_NEAR(scales.Scale(JointClass::kWrist), 1.035, 0.035);
}

TEST(NoiseScalesTest, RarelySeenClassUsesThePersonsScale) {
  Random random(3);
  NoiseScales scales;
  EXPECT_EQ(scales.Scale(JointClass::kHead), 1.0);
  for (int i = 0; i < 2000; ++i) {
    scales.Add(JointClass::kHip, Draw(0.5, &random));
  }
  for (int i = 0; i < 4; ++i) {
    scales.Add(JointClass::kAnkle, Draw(4.0, &random));
  }
  // The difference of ln 8 has the weight 4 / 44.
  EXPECT_NEAR(std::log(scales.Scale(JointClass::kAnkle) /
                       scales.Scale(JointClass::kHip)),
              std::log(8.0) * 4.0 / 44.0, 0.1);
  // The person's scale is that of all classes together. Four of 2004 values
  // change the 0.3 quantile by well below one per cent of the scale, and the
  // prior (20 joints of scale 1) changes the scale by 20 / 2024 ln 2 = 0.7 %.
  EXPECT_NEAR(scales.Scale(JointClass::kHead) / scales.Scale(JointClass::kHip),
              1.0, 0.02);
}

// Fits the correlation of one joint in four views over `seconds`, for AR(1)
// errors with the given share and correlation time.
ErrorCorrelation FitSimulated(double share, double time_s, double rate_hz,
                              double seconds, uint64_t seed) {
  constexpr int kViews = 4;
  Random random(seed);
  CorrelationLearner learner(1, kViews, rate_hz);
  std::vector<Eigen::Vector2d> slow(kViews);
  for (Eigen::Vector2d& s : slow) s << random.Normal(), random.Normal();
  const double phi = std::exp(-1.0 / (rate_hz * time_s));
  const double root = std::sqrt(1.0 - phi * phi);
  for (int k = 0; k < static_cast<int>(seconds * rate_hz); ++k) {
    TriangulationResiduals residuals;
    for (int v = 0; v < kViews; ++v) {
      slow[v] = phi * slow[v] +
                root * Eigen::Vector2d(random.Normal(), random.Normal());
      TriangulationResiduals::View& view = residuals.views.emplace_back();
      view.view_idx = v;
      view.residual = std::sqrt(share) * slow[v] +
                      std::sqrt(1.0 - share) *
                          Eigen::Vector2d(random.Normal(), random.Normal());
      // Five of eight degrees of freedom remain, which reduces the sum of
      // squares accordingly.
      residuals.square += 5.0 / 8.0 * view.residual.squaredNorm();
    }
    learner.Add(0, FromSeconds(k / rate_hz), 1.0, residuals);
  }
  return learner.Fit();
}

TEST(CorrelationLearnerTest, EstimatesShareAndCorrelationTime) {
  // 60 s of errors with a correlation time of 0.1 s have 60 / 0.2 independent
  // values in each of eight coordinates, so correlations are accurate to 1 /
  // sqrt(2400) = 0.02, and the correlation time to about a tenth. Frames with
  // large residuals are left out, which shortens it slightly.
  for (const double rate_hz : {25.0, 120.0}) {
    const ErrorCorrelation fit = FitSimulated(0.9, 0.1, rate_hz, 60.0, 4);
    EXPECT_NEAR(fit.share, 0.9, 0.1) << rate_hz;
    EXPECT_NEAR(fit.time_s, 0.1, 0.03) << rate_hz;
  }
}

TEST(CorrelationLearnerTest, WhiteErrorsHaveNoCorrelatedShare) {
  for (const double rate_hz : {30.0, 120.0, 240.0}) {
    EXPECT_EQ(FitSimulated(0.0, 0.1, rate_hz, 60.0, 5).share, 0.0) << rate_hz;
  }
}

TEST(CorrelationLearnerTest, SmallShareIsKeptOnlyAtHighFrameRates) {
  // Below 1 / (0.5 s) the correlated part has 2 * 0.1 * 0.5 s / 0.9 * rate
  // times the power of the white part: 27 times at 240 Hz, 2.8 times at 25 Hz,
  // where it is neglected.
  EXPECT_NEAR(FitSimulated(0.1, 0.5, 240.0, 60.0, 6).share, 0.1, 0.04);
  EXPECT_EQ(FitSimulated(0.1, 0.5, 25.0, 60.0, 6).share, 0.0);
}

TEST(CorrelationLearnerTest, ConstantErrorHasALongCorrelationTime) {
  // A fifth of the variance is practically constant and must not appear to
  // decay over a quarter of a second. With 60 s at 60 Hz correlations are
  // accurate to about 1 / sqrt(8 * 3600) = 0.006; with a correlation time of 2
  // s the correlation at the longest lag would differ by 0.2 * (1 - exp(-0.25 /
  // 2)) = 0.024.
  const ErrorCorrelation fit = FitSimulated(0.2, 1e6, 60.0, 60.0, 7);
  EXPECT_GT(fit.time_s, 2.0);
  EXPECT_LT(fit.time_s, 10.0);
  EXPECT_GT(fit.share, 0.0);
}

TEST(CorrelationLearnerTest, EqualsThePriorWithoutObservations) {
  const ErrorCorrelation fit = CorrelationLearner(17, 4, 25.0).Fit();
  EXPECT_NEAR(fit.share, 0.9, 0.02);
  EXPECT_NEAR(fit.time_s, 0.1, 0.01);
}

}  // namespace
}  // namespace kinegraph
