#include "solvers/filters/savitzky_golay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "solvers/filters/segment_filters.h"
#include "tests/support/signals.h"

namespace kinegraph {
namespace {

TEST(SavitzkyGolayTest, ImpulseIsTheTableOfThePaper) {
  // Savitzky and Golay 1964, table I: seven points, quadratic and cubic,
  // (-2 3 6 7 6 3 -2) / 21.
  const double table[] = {-2.0, 3.0, 6.0, 7.0, 6.0, 3.0, -2.0};
  const Samples two = SavitzkyGolay(7, 2, testing::Impulse(21, 10));
  const Samples three = SavitzkyGolay(7, 3, testing::Impulse(21, 10));
  for (int k = 0; k < 7; ++k) {
    EXPECT_NEAR(two(7 + k, 0), table[k] / 21.0, 1e-15) << k;
    EXPECT_NEAR(three(7 + k, 0), table[k] / 21.0, 1e-15) << k;
  }
  EXPECT_NEAR(two.topRows(4).norm(), 0.0, 1e-15);
}

TEST(SavitzkyGolayTest, StepIsTheSumOfTheTable) {
  const double sums[] = {-2.0, 1.0, 7.0, 14.0, 20.0, 23.0, 21.0};
  const Samples step = SavitzkyGolay(7, 2, testing::Step(21, 10));
  for (int k = 0; k < 7; ++k) {
    EXPECT_NEAR(step(7 + k, 0), sums[k] / 21.0, 1e-15) << k;
  }
}

TEST(SavitzkyGolayTest, EdgesAreScipys) {
  // scipy 1.10.1: signal.savgol_filter(x, 9, 3)[[0, 1, 15, 28, 29]] and
  // signal.savgol_filter(x, 7, 2)[...], x = testing::Wiggle(30).
  const int places[] = {0, 1, 15, 28, 29};
  const double nine[] = {0.01894161481667722, 0.4160661716163582,
                         0.5409140977964515, 3.654991074386889,
                         3.529989961071933};
  const double seven[] = {0.01376051334216093, 0.4214895372267477,
                          0.5138416298102059, 3.649968437031076,
                          3.531730723922287};
  const Samples values = testing::Wiggle(30);
  const Samples with_nine = SavitzkyGolay(9, 3, values);
  const Samples with_seven = SavitzkyGolay(7, 2, values);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(with_nine(places[i], 0), nine[i], 1e-13) << places[i];
    EXPECT_NEAR(with_seven(places[i], 0), seven[i], 1e-13) << places[i];
  }
}

TEST(SavitzkyGolayTest, FrequencyResponseIsTheSumOfCosines) {
  for (const double f : {1.0, 4.0, 8.0, 12.0}) {
    const double w = 2.0 * M_PI * f / 25.0;
    const double expected =
        (7.0 + 12.0 * std::cos(w) + 6.0 * std::cos(2.0 * w) -
         4.0 * std::cos(3.0 * w)) /
        21.0;
    const double gain = testing::Gain(
        [](const Samples& values) { return SavitzkyGolay(7, 2, values); }, f,
        25.0);
    EXPECT_NEAR(gain, expected, 1e-13) << f;
  }
}

TEST(SavitzkyGolayTest, PolynomialsPassAndShortSignalsAreFittedWhole) {
  for (const int count : {1, 2, 4, 5, 8, 9, 30}) {
    Samples values(count, 1);
    for (int k = 0; k < count; ++k) {
      values(k, 0) = 1.0 - 0.3 * k + 0.02 * k * k - 1e-3 * k * k * k;
    }
    EXPECT_LT((SavitzkyGolay(9, 3, values) - values).cwiseAbs().maxCoeff(),
              1e-12)
        << count;
  }
}

TEST(SavitzkyGolayTest, WindowsAreOddNumbersOfFrames) {
  SavitzkyGolayOptions options;  // 0.36 s, order 3
  EXPECT_EQ(SavitzkyGolayLength(options, 25.0), 9);
  EXPECT_EQ(SavitzkyGolayLength(options, 60.0), 21);   // 21.6
  EXPECT_EQ(SavitzkyGolayLength(options, 120.0), 43);  // 43.2
  options.window_s = 0.0;
  EXPECT_EQ(SavitzkyGolayLength(options, 25.0), 5);  // order 3 needs four
}

TEST(SavitzkyGolayTest, RefusesUnevenTime) {
  JointSegment segment;
  segment.times_s = {0.0, 0.04, 0.12};
  segment.positions_m = Samples::Zero(3, 3);
  try {
    SavitzkyGolayFilter({}, 25.0)(segment);
    FAIL() << "a dropped frame was accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'savitzky_golay' needs uniform"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace kinegraph
