#include "core/geometry/ball_probability.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/base/constants.h"
#include "core/base/random.h"

namespace kinegraph {
namespace {

constexpr double kRadius_m = 0.05;

Eigen::Matrix3d Covariance(double a_mm, double b_mm, double c_mm) {
  const Eigen::Vector3d sigma_m = 1e-3 * Eigen::Vector3d(a_mm, b_mm, c_mm);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())
          .toRotationMatrix();
  return turn * sigma_m.cwiseAbs2().asDiagonal() * turn.transpose();
}

// An isotropic covariance gives Maxwell's distribution, a single axis a normal
// distribution. The tolerance bounds the error of the numerical integration.
TEST(BallProbability, MatchesMaxwellAndNormalDistributions) {
  for (const double sigma_mm : {10.0, 20.0, 24.02, 30.0, 50.0, 100.0, 1000.0}) {
    const double r = 1e3 * kRadius_m / sigma_mm;
    const double expected = std::erf(r / std::sqrt(2.0)) -
                            std::sqrt(2.0 / kPi) * r * std::exp(-0.5 * r * r);
    EXPECT_NEAR(
        ProbabilityWithin(kRadius_m, Covariance(sigma_mm, sigma_mm, sigma_mm)),
        expected, 1e-5);
    EXPECT_NEAR(ProbabilityWithin(kRadius_m, Covariance(0, sigma_mm, 0)),
                std::erf(r / std::sqrt(2.0)), 1e-5);
  }
  EXPECT_EQ(ProbabilityWithin(kRadius_m, Covariance(1, 1, 1)), 1.0);
  EXPECT_EQ(ProbabilityWithin(kRadius_m, Eigen::Matrix3d::Zero()), 1.0);
}

// Monte Carlo with 200,000 samples; the tolerance is 4 standard errors.
TEST(BallProbability, MatchesMonteCarlo) {
  Random random(5);
  for (const Eigen::Vector3d& mm :
       {Eigen::Vector3d(100, 5, 5), Eigen::Vector3d(41, 14, 17),
        Eigen::Vector3d(100, 100, 5), Eigen::Vector3d(50, 30, 10)}) {
    constexpr int kDraws = 200000;
    int inside = 0;
    for (int i = 0; i < kDraws; ++i) {
      const Eigen::Vector3d point_m(1e-3 * mm[0] * random.Normal(),
                                    1e-3 * mm[1] * random.Normal(),
                                    1e-3 * mm[2] * random.Normal());
      inside += point_m.norm() < kRadius_m ? 1 : 0;
    }
    const double share = static_cast<double>(inside) / kDraws;
    EXPECT_NEAR(ProbabilityWithin(kRadius_m, Covariance(mm[0], mm[1], mm[2])),
                share, 4.0 * std::sqrt(share * (1.0 - share) / kDraws));
  }
}

}  // namespace
}  // namespace kinegraph
