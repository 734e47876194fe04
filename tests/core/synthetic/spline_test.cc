#include "core/synthetic/spline.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kinegraph {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRounding = 1e-12;  // of sums of a few terms near one

double Cubic(double t) { return 0.3 - 1.2 * t + 0.7 * t * t - 0.4 * t * t * t; }

KnotSpline Through(const std::vector<double>& times, double (*f)(double)) {
  MatrixXd values(2, static_cast<Eigen::Index>(times.size()));
  for (size_t i = 0; i < times.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    values(0, column) = f(times[i]);
    values(1, column) = -2.0 * f(times[i]);
  }
  return KnotSpline(times, values);
}

TEST(KnotSpline, PassesThroughTheKnots) {
  const std::vector<double> times = {0.0, 0.1, 0.25, 0.3, 0.7, 1.1};
  const KnotSpline spline =
      Through(times, [](double t) { return std::sin(9 * t); });
  for (const double t : times) {
    EXPECT_NEAR(spline.At(t)(0), std::sin(9 * t), kRounding) << t;
    EXPECT_NEAR(spline.At(t)(1), -2.0 * std::sin(9 * t), kRounding) << t;
  }
}

// Without assumptions at the ends, a cubic is reproduced exactly, unlike by a
// natural or a clamped spline.
TEST(KnotSpline, ReproducesCubics) {
  for (const std::vector<double>& times :
       {std::vector<double>{0.0, 0.2, 0.5, 1.0},
        std::vector<double>{0.0, 0.1, 0.3, 0.35, 0.8, 0.9, 1.0}}) {
    const KnotSpline spline = Through(times, Cubic);
    for (int i = 0; i <= 100; ++i) {
      const double t = 0.01 * i;
      EXPECT_NEAR(spline.At(t)(0), Cubic(t), kRounding) << t;
    }
  }
}

TEST(KnotSpline, ThreeKnotsGiveAParabolaAndTwoALine) {
  const auto parabola = [](double t) { return 1.0 + t - 3.0 * t * t; };
  const KnotSpline three = Through({0.0, 0.4, 1.0}, parabola);
  EXPECT_NEAR(three.At(0.7)(0), parabola(0.7), kRounding);
  const auto line = [](double t) { return 2.0 - 5.0 * t; };
  EXPECT_NEAR(Through({0.0, 1.0}, line).At(0.3)(0), line(0.3), kRounding);
}

TEST(KnotSpline, DoesNotExtrapolate) {
  const KnotSpline spline = Through({0.0, 0.2, 0.5, 1.0}, Cubic);
  EXPECT_EQ(spline.At(-5.0), spline.At(0.0));
  EXPECT_EQ(spline.At(5.0), spline.At(1.0));
}

// de Boor: the error of a cubic spline is of fourth order in the interval.
TEST(KnotSpline, ConvergesWithTheFourthPower) {
  const auto worst = [](int intervals) {
    std::vector<double> times;
    for (int i = 0; i <= intervals; ++i) {
      times.push_back(static_cast<double>(i) / intervals);
    }
    const KnotSpline spline =
        Through(times, [](double t) { return std::sin(6 * t); });
    double error = 0.0;
    for (int i = 0; i <= 1000; ++i) {
      error = std::max(error,
                       std::abs(spline.At(0.001 * i)(0) - std::sin(0.006 * i)));
    }
    return error;
  };
  // 2^4 = 16 in the limit; the ends converge more slowly.
  EXPECT_GT(worst(20) / worst(40), 12.0);
}

}  // namespace
}  // namespace kinegraph
