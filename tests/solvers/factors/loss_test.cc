#include "solvers/factors/loss.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "core/base/random.h"
#include "solvers/ceres/ceres_factor.h"

namespace kinegraph {
namespace {

constexpr LossKind kAll[] = {LossKind::kNone, LossKind::kHuber,
                             LossKind::kCauchy, LossKind::kGemanMcClure,
                             LossKind::kTukey};

TEST(Loss, HandWorkedValues) {
  // With c = 3, s = 9 is a residual of one scale and s = 36 (Huber) one of two
  // scales.
  EXPECT_DOUBLE_EQ(EvaluateLoss(LossKind::kNone, 3.0, 9.0).rho, 9.0);
  EXPECT_DOUBLE_EQ(EvaluateLoss(LossKind::kHuber, 3.0, 36.0).rho, 27.0);
  EXPECT_DOUBLE_EQ(EvaluateLoss(LossKind::kHuber, 3.0, 36.0).first, 0.5);
  EXPECT_DOUBLE_EQ(EvaluateLoss(LossKind::kCauchy, 3.0, 9.0).rho,
                   9.0 * std::log(2.0));
  EXPECT_DOUBLE_EQ(EvaluateLoss(LossKind::kCauchy, 3.0, 9.0).first, 0.5);
  EXPECT_DOUBLE_EQ(EvaluateLoss(LossKind::kGemanMcClure, 3.0, 9.0).rho, 4.5);
  EXPECT_DOUBLE_EQ(EvaluateLoss(LossKind::kGemanMcClure, 3.0, 9.0).first, 0.25);
  EXPECT_DOUBLE_EQ(EvaluateLoss(LossKind::kTukey, 3.0, 9.0).rho, 3.0);
  EXPECT_DOUBLE_EQ(EvaluateLoss(LossKind::kTukey, 3.0, 9.0).first, 0.0);
}

TEST(Loss, DerivativesMatchFiniteDifferences) {
  for (const LossKind kind : kAll) {
    for (const double s : {0.0, 0.3, 2.0, 8.0, 40.0}) {
      const double h = 1e-5;
      const double low = s > h ? s - h : s;
      const LossValue a = EvaluateLoss(kind, 2.5, low);
      const LossValue b = EvaluateLoss(kind, 2.5, s + h);
      const LossValue middle = EvaluateLoss(kind, 2.5, 0.5 * (low + s + h));
      // Central differences: step^2 and rounding over the step, both ~1e-10.
      EXPECT_NEAR((b.rho - a.rho) / (s + h - low), middle.first, 1e-8);
      EXPECT_NEAR((b.first - a.first) / (s + h - low), middle.second, 1e-8);
    }
  }
}

TEST(Loss, CeresLossesHaveTheSameValues) {
  EXPECT_EQ(MakeCeresLoss(LossKind::kNone, 2.5), nullptr);
  for (const LossKind kind : {LossKind::kHuber, LossKind::kCauchy,
                              LossKind::kGemanMcClure, LossKind::kTukey}) {
    const std::unique_ptr<ceres::LossFunction> loss(MakeCeresLoss(kind, 2.5));
    for (const double s : {0.0, 0.5, 6.0, 7.0, 100.0}) {
      double rho[3];
      loss->Evaluate(s, rho);
      const LossValue own = EvaluateLoss(kind, 2.5, s);
      EXPECT_NEAR(rho[0], own.rho, 1e-12);
      EXPECT_NEAR(rho[1], own.first, 1e-12);
      EXPECT_NEAR(rho[2], own.second, 1e-12);
    }
  }
}

TEST(Loss, SecondDerivativeIsNeverPositive) {
  // For losses without positive second derivatives, Ceres only scales residuals
  // and Jacobians, which is reweighted least squares.
  for (const LossKind kind : kAll) {
    for (double s = 0.0; s < 50.0; s += 0.1) {
      EXPECT_LE(EvaluateLoss(kind, 2.0, s).second, 0.0);
    }
  }
}

TEST(InformationCorrection, IsOneWithoutLossAndForLargeScales) {
  EXPECT_NEAR(InformationCorrection(LossKind::kNone, 1.0), 1.0, 1e-6);
  for (const LossKind kind : kAll) {
    EXPECT_NEAR(InformationCorrection(kind, 1000.0), 1.0, 1e-4);
  }
}

TEST(InformationCorrection, PredictsTheSpreadOfALocationEstimate) {
  // The M-estimate of a 2D location from 400 normal observations, by
  // reweighting: its variance is compared with the variance reported with the
  // correction.
  Random random(11);
  for (const LossKind kind : {LossKind::kHuber, LossKind::kGemanMcClure,
                              LossKind::kTukey, LossKind::kCauchy}) {
    const double scale = kind == LossKind::kTukey ? 4.0 : 2.0;
    const double correction = InformationCorrection(kind, scale);
    constexpr int kRuns = 1500;
    constexpr int kCount = 400;
    double nees = 0.0;
    for (int run = 0; run < kRuns; ++run) {
      std::vector<std::pair<double, double>> points(kCount);
      for (auto& [x, y] : points) {
        x = random.Normal();
        y = random.Normal();
      }
      double cx = 0.0;
      double cy = 0.0;
      double total = 0.0;
      for (int iteration = 0; iteration < 15; ++iteration) {
        double sx = 0.0;
        double sy = 0.0;
        total = 0.0;
        for (const auto& [x, y] : points) {
          const double s = (x - cx) * (x - cx) + (y - cy) * (y - cy);
          const double w = EvaluateLoss(kind, scale, s).first;
          sx += w * x;
          sy += w * y;
          total += w;
        }
        cx = sx / total;
        cy = sy / total;
      }
      nees += (cx * cx + cy * cy) * total * correction;
    }
    // A mean of 1500 chi-squares with 2 degrees of freedom, over 2, has a
    // standard error of 1 / sqrt(1500) = 2.6 %. The tolerance is four standard
    // errors.
    EXPECT_NEAR(nees / kRuns / 2.0, 1.0, 0.105)
        << LossNames()[static_cast<int>(kind)];
  }
}

}  // namespace
}  // namespace kinegraph
