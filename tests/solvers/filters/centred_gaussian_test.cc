#include "solvers/filters/centred_gaussian.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/signals.h"

namespace kinegraph {
namespace {

TEST(CentredGaussianTest, InsideAndAtTheEdgesAsNumpyHasIt) {
  // x as testing::Wiggle(30) says; sigma 0.05 s at 25 Hz, radius 4 sigmas = 5
  // frames. numpy 1.24.2:
  //   w = np.exp(-.5 * (np.arange(-5, 6) * .04 / .05)**2)
  //   (np.convolve(x, w, 'same') / np.convolve(np.ones(30), w, 'same'))
  //     [[0, 1, 15, 28, 29]]
  // Place 15 is scipy.ndimage.gaussian_filter1d(x, 1.25)[15] too.
  const int places[] = {0, 1, 15, 28, 29};
  const double expected[] = {0.2874968691802849, 0.4824789590364859,
                             0.5887899257028587, 3.619712452956263,
                             3.597963959257704};
  const Samples smoothed =
      CentredGaussian(0.05, testing::UniformTimes(30), testing::Wiggle(30));
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(smoothed(places[i], 0), expected[i], 1e-13) << places[i];
  }
}

TEST(CentredGaussianTest, ImpulseAndStepAreTheKernelAndItsSum) {
  const auto times_s = testing::UniformTimes(41);
  const double sigma_s = 0.06;  // 1.5 frames, radius 6
  double total = 0.0;
  for (int k = -6; k <= 6; ++k) total += std::exp(-0.5 * k * k / 2.25);
  const Samples impulse =
      CentredGaussian(sigma_s, times_s, testing::Impulse(41, 20));
  const Samples step = CentredGaussian(sigma_s, times_s, testing::Step(41, 20));
  double sum = 0.0;
  for (int k = -8; k <= 8; ++k) {
    const double weight =
        std::abs(k) <= 6 ? std::exp(-0.5 * k * k / 2.25) / total : 0.0;
    sum += weight;
    EXPECT_NEAR(impulse(20 + k, 0), weight, 1e-15) << k;
    EXPECT_NEAR(step(20 + k, 0), sum, 1e-14) << k;
  }
}

TEST(CentredGaussianTest, FrequencyResponseIsGaussian) {
  // exp(-(2 pi f sigma)^2 / 2) of the endless, continuous kernel. The kernel
  // is cut at four sigmas (its tails weigh 6e-5) and sampled every 1.25
  // sigmas or finer: its first alias is exp(-(2 pi 0.8)^2 / 2) = 3e-6.
  for (const double rate_hz : {25.0, 60.0, 120.0}) {
    const auto times_s = testing::UniformTimes(2001, rate_hz);
    for (const double f : {0.5, 2.0, 4.0}) {
      const double gain = testing::Gain(
          [&](const Samples& values) {
            return CentredGaussian(0.05, times_s, values);
          },
          f, rate_hz);
      EXPECT_NEAR(gain, std::exp(-0.5 * std::pow(2.0 * M_PI * f * 0.05, 2)),
                  2e-4)
          << f << " Hz at " << rate_hz;
    }
  }
}

TEST(CentredGaussianTest, UnevenTimeWeighsByTime) {
  // Three values, one far: weights exp(-t^2 / (2 sigma^2)) by hand.
  Samples values(3, 1);
  values << 1.0, 2.0, 4.0;
  const Samples smoothed = CentredGaussian(0.1, {0.0, 0.1, 0.3}, values);
  const double a = std::exp(-0.5);
  const double b = std::exp(-4.5);
  const double c = std::exp(-2.0);
  EXPECT_NEAR(smoothed(0, 0), (1.0 + 2.0 * a + 4.0 * b) / (1.0 + a + b), 1e-14);
  EXPECT_NEAR(smoothed(1, 0), (a + 2.0 + 4.0 * c) / (a + 1.0 + c), 1e-14);
  EXPECT_NEAR(smoothed(2, 0), (b + 2.0 * c + 4.0) / (b + c + 1.0), 1e-14);
}

}  // namespace
}  // namespace kinegraph
