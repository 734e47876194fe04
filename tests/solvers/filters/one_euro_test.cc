#include "solvers/filters/one_euro.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "solvers/filters/segment_filters.h"
#include "tests/support/signals.h"

namespace kinegraph {
namespace {

// Known answers by the paper's algorithm 1 in Python (min. cut-off 1, beta 0.5,
// derivative cut-off 1), x and t as the signals say:
//   a = lambda dt, fc: 1 / (1 + 1 / (2 * np.pi * fc) / dt)
//   y, e = [x[0]], 0.0
//   for i in range(1, len(x)):
//     dt = t[i] - t[i-1]; e += a(dt, 1.0) * ((x[i] - y[-1]) / dt - e)
//     y.append(y[-1] + a(dt, 1.0 + 0.5 * abs(e)) * (x[i] - y[-1]))
const OneEuroOptions kOptions = {1.0, 0.5};

TEST(OneEuroTest, StepAndImpulse) {
  const std::vector<double> step = {0.0,
                                    0.0,
                                    0.0,
                                    0.4687384542527157,
                                    0.7459048293349242,
                                    0.8779867550520046,
                                    0.9387657559412177,
                                    0.9674688550167811,
                                    0.9816841311342033,
                                    0.989112418544337};
  const std::vector<double> impulse = {0.0,
                                       0.0,
                                       0.0,
                                       0.4687384542527157,
                                       0.3210948903733871,
                                       0.2494285909082301,
                                       0.1735181886674621,
                                       0.1149448868723899,
                                       0.07511576142444244,
                                       0.04936581443902049};
  const auto times_s = testing::UniformTimes(10);
  const Samples after_step = OneEuro(kOptions, times_s, testing::Step(10, 3));
  const Samples after_impulse =
      OneEuro(kOptions, times_s, testing::Impulse(10, 3));
  for (int k = 0; k < 10; ++k) {
    EXPECT_NEAR(after_step(k, 0), step[static_cast<size_t>(k)], 1e-14) << k;
    EXPECT_NEAR(after_impulse(k, 0), impulse[static_cast<size_t>(k)], 1e-14)
        << k;
  }
}

TEST(OneEuroTest, UnevenTime) {
  const int places[] = {0, 1, 2, 15, 28, 29};
  const double expected[] = {0.05,
                             0.1554015369335859,
                             0.3848691357996041,
                             0.5909494962435787,
                             3.636285767367925,
                             3.575896477631622};
  const Samples filtered =
      OneEuro(kOptions, testing::UnevenTimes(30), testing::Wiggle(30));
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(filtered(places[i], 0), expected[i], 1e-13) << places[i];
  }
}

TEST(OneEuroTest, WithoutBetaItIsExponentialSmoothing) {
  // al = 1 / (1 + 1 / (2 pi 1.5) / 0.04); scipy 1.10.1:
  // signal.lfilter([al], [1, al - 1], x, zi=[x[0] * (1 - al)])[0]
  const int places[] = {0, 1, 15, 29};
  const double expected[] = {0.05, 0.1309071981198498, 0.7352923114698284,
                             3.338964092725327};
  const Samples filtered =
      OneEuro({1.5, 0.0}, testing::UniformTimes(30), testing::Wiggle(30));
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(filtered(places[i], 0), expected[i], 1e-13) << places[i];
  }
  // Frequency response: the real part of a / (1 - (1 - a) e^-iw), since the
  // crest of the cosine is looked at.
  const double ratio = 2.0 * M_PI * 1.5 * 0.04;
  const double a = ratio / (1.0 + ratio);
  const auto times_s = testing::UniformTimes(2001);
  for (const double f : {0.5, 1.5, 5.0}) {
    const auto z = std::polar(1.0, -2.0 * M_PI * f * 0.04);
    const double expected_gain = (a / (1.0 - (1.0 - a) * z)).real();
    const double gain = testing::Gain(
        [&](const Samples& values) {
          return OneEuro({1.5, 0.0}, times_s, values);
        },
        f, 25.0);
    EXPECT_NEAR(gain, expected_gain, 1e-12) << f;
  }
}

TEST(OneEuroTest, IsCausalAndHoldsInGaps) {
  JointSegment segment;
  segment.times_s = testing::UniformTimes(6);
  segment.positions_m = Samples::Zero(6, 3);
  segment.positions_m.col(0) << 0.0, 1.0, 2.0, 3.0, 4.0, 5.0;
  segment.sampled = {1, 1, 0, 0, 0, 1};
  const Samples filtered = OneEuroFilter(kOptions)(segment).positions_m;
  for (int k = 2; k < 5; ++k) EXPECT_EQ(filtered(k, 0), filtered(1, 0));
  // The sample after the gap came 0.16 s after the one before.
  Samples three(3, 1);
  three << 0.0, 1.0, 5.0;
  EXPECT_EQ(filtered(5, 0), OneEuro(kOptions, {0.0, 0.04, 0.2}, three)(2, 0));
}

}  // namespace
}  // namespace kinegraph
