#include "solvers/filters/smoothing_spline.h"

#include <gtest/gtest.h>

#include "solvers/filters/offline_filter.h"
#include "solvers/filters/penalised.h"
#include "tests/support/signals.h"

namespace kinegraph {
namespace {

using testing::ExpectPlaces;

// Expected values with all digits are from
// scipy.interpolate.make_smoothing_spline (scipy 1.10.1); x is
// testing::Wiggle(30), t the times of each test.

TEST(SmoothingSplineTest, EqualsScipyForAGivenLambda) {
  // s = make_smoothing_spline(t, x, lam=1e-4); s(t[[0, 1, 15, 28, 29]]) and
  // s([0.05, 0.5, 1.13]).
  const Samples values = testing::Wiggle(30);
  const auto even_s = testing::UniformTimes(30);
  ExpectPlaces(SmoothingSpline(1e-4, even_s, values, even_s),
               {0, 1, 15, 28, 29},
               {0.05327894903997576, 0.4117218645293546, 0.5340153338821643,
                3.643060235352621, 3.595694967893229},
               1e-12);
  const std::vector<double> between_s = {0.05, 0.5, 1.13};
  ExpectPlaces(SmoothingSpline(1e-4, even_s, values, between_s), {0, 1, 2},
               {0.5009763361272546, 0.6855917345363307, 3.63411431931116},
               1e-12);
  const auto uneven_s = testing::UnevenTimes(30);
  ExpectPlaces(SmoothingSpline(1e-4, uneven_s, values, uneven_s),
               {0, 1, 15, 28, 29},
               {0.0359904389445469, 0.5019520537127053, 0.5333775732329449,
                3.639794555652607, 3.601979672352631},
               1e-12);
  ExpectPlaces(SmoothingSpline(1e-4, uneven_s, values, between_s), {0, 1, 2},
               {0.4846678914697284, 0.6917008021532127, 3.625926554544184},
               1e-12);
}

TEST(SmoothingSplineTest, DerivativesEqualDifferencesOfTheCurve) {
  // Within an interval the second difference of a cubic is exact; the error of
  // the first is the cubic's third derivative, below 1e5 here, times h^2 / 6;
  // rounding is 1e-15 / h^2.
  constexpr double kH = 1e-4;
  const auto times_s = testing::UnevenTimes(30);
  const std::vector<double> at_s = {-0.3, 0.052, 0.511, 1.13, 1.5};
  std::vector<double> before_s, after_s;
  for (const double t : at_s) {
    before_s.push_back(t - kH);
    after_s.push_back(t + kH);
  }
  const Samples values = testing::Wiggle(30);
  const auto curve = [&](const std::vector<double>& t) {
    return SmoothingSpline(1e-4, times_s, values, t);
  };
  CurveDerivatives found;
  const Samples f = SmoothingSpline(1e-4, times_s, values, at_s, &found);
  EXPECT_EQ(f, curve(at_s));
  EXPECT_LT((found.first - (curve(after_s) - curve(before_s)) / (2.0 * kH))
                .cwiseAbs()
                .maxCoeff(),
            1e-3);
  EXPECT_LT(
      (found.second - (curve(after_s) - 2.0 * f + curve(before_s)) / (kH * kH))
          .cwiseAbs()
          .maxCoeff(),
      1e-5);
}

TEST(SmoothingSplineTest, LambdaHasTheLeastScoreOfTheDenseInfluenceMatrix) {
  // Column i of the influence matrix A is make_smoothing_spline(t, e_i,
  // lam=l)(t), uneven t; r = x - A x; the score is
  // 30 * (r @ r) / np.trace(np.eye(30) - A)**2.
  // scipy.optimize.minimize_scalar over log10 l, bounds -8 and -2, xatol 1e-10:
  // l = 0.00011323759541927564. Near the minimum the score is flat, so its
  // location is known only to the square root of machine precision.
  const Samples values = testing::Wiggle(30);
  const auto times_s = testing::UnevenTimes(30);
  const double lambda_s3 = ChooseLambdaByGcv(times_s, values);
  EXPECT_NEAR(lambda_s3 / 0.00011323759541927564, 1.0, 1e-5);
  ExpectPlaces(SmoothingSpline(lambda_s3, times_s, values, times_s),
               {0, 1, 15, 28, 29},
               {0.03905145176392938, 0.504031179781778, 0.535823323358409,
                3.640620592591196, 3.607929756337134},
               1e-6);
}

TEST(SmoothingSplineTest, ColumnsShareOneLambda) {
  const auto times_s = testing::UniformTimes(30);
  Samples values(30, 2);
  values << testing::Wiggle(30), testing::Wiggle(30);
  // A column with more noise needs a larger lambda.
  for (int k = 0; k < 30; ++k) values(k, 1) += k % 2 == 0 ? 0.2 : -0.2;
  const double both = ChooseLambdaByGcv(times_s, values);
  EXPECT_GT(both, 1.1 * ChooseLambdaByGcv(times_s, values.col(0)));
  EXPECT_LT(1.1 * both, ChooseLambdaByGcv(times_s, values.col(1)));
}

TEST(SmoothingSplineTest, CutoffHalvesTheAmplitude) {
  // The gain is 1 / (1 + (f / cutoff)^4) if f is far below the frame rate.
  const auto times_s = testing::UniformTimes(2001, 120.0);
  const auto smooth = [&](const Samples& values) {
    const auto curve =
        MakeCubicSpline(times_s, std::vector<char>(2001, 1), values);
    return curve->Fit(curve->LambdaOf(3.0));
  };
  EXPECT_NEAR(testing::Gain(smooth, 3.0, 120.0), 0.5, 1e-3);
  EXPECT_NEAR(testing::Gain(smooth, 1.0, 120.0), 81.0 / 82.0, 1e-3);
}

TEST(SmoothingSplineTest,
     IsLinearOutsideInterpolatesForZeroLambdaAndKeepsLines) {
  const auto times_s = testing::UniformTimes(30);
  const Samples values = testing::Wiggle(30);
  // Outside, equal steps in time give equal differences.
  const Samples outside = SmoothingSpline(1e-4, times_s, values,
                                          {-0.2, -0.1, 0.0, 1.16, 1.26, 1.36});
  EXPECT_NEAR(outside(0, 0) - outside(1, 0), outside(1, 0) - outside(2, 0),
              1e-12);
  EXPECT_NEAR(outside(4, 0) - outside(3, 0), outside(5, 0) - outside(4, 0),
              1e-12);
  // With lambda 0 the spline interpolates; a line is unchanged by any lambda.
  EXPECT_LT((SmoothingSpline(0.0, times_s, values, times_s) - values).norm(),
            1e-12);
  Samples line(30, 1);
  for (int k = 0; k < 30; ++k) line(k, 0) = 2.0 - 0.1 * k;
  EXPECT_LT((SmoothingSpline(1.0, times_s, line, times_s) - line).norm(),
            1e-10);
}

TEST(SmoothingSplineTest, IgnoresBridgedSamplesInGaps) {
  // A parabola with frames 10 to 14 bridged by a (wrong) line: the spline uses
  // only the samples and follows the curve.
  JointSegment segment;
  segment.times_s = testing::UniformTimes(30);
  segment.positions_m.resize(30, 3);
  segment.sampled.assign(30, 1);
  const auto curve = [](double t) { return 3.0 * t * t; };
  for (int k = 0; k < 30; ++k) {
    const bool gap = k >= 10 && k < 15;
    segment.sampled[k] = !gap;
    const double share = (k - 9) / 6.0;
    const double linear = (1.0 - share) * curve(0.36) + share * curve(0.6);
    segment.positions_m.row(k).setConstant(gap ? linear : curve(0.04 * k));
  }
  const Samples smoothed = SmoothingSplineFilter({}, 25.0)(segment).positions_m;
  // In the middle the line is 3 * 0.12^2 = 43 mm off.
  EXPECT_NEAR(segment.positions_m(12, 0) - curve(0.48), 0.0432, 1e-4);
  for (int k = 10; k < 15; ++k) {
    EXPECT_NEAR(smoothed(k, 0), curve(0.04 * k), 2e-3) << k;
  }
}

TEST(SmoothingSplineTest, FewerThanFiveSamplesAreUnchanged) {
  for (int count = 1; count < 5; ++count) {
    JointSegment segment;
    segment.times_s = testing::UniformTimes(count);
    segment.positions_m = testing::Wiggle(count).replicate(1, 3);
    segment.sampled.assign(static_cast<size_t>(count), 1);
    EXPECT_EQ(SmoothingSplineFilter({}, 25.0)(segment).positions_m,
              segment.positions_m);
  }
}

}  // namespace
}  // namespace kinegraph
