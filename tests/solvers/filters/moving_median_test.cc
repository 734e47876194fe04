#include "solvers/filters/moving_median.h"

#include <gtest/gtest.h>

#include <vector>

#include "solvers/filters/segment_filters.h"
#include "tests/support/signals.h"

namespace kinegraph {
namespace {

// A ramp with two spikes.
Samples Spiky() {
  Samples values(12, 1);
  values << 0.0, 0.1, 0.2, 5.0, 0.4, 0.5, 0.6, 0.7, -3.0, 0.9, 1.0, 1.1;
  return values;
}

void ExpectColumn(const Samples& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.rows(), static_cast<Eigen::Index>(expected.size()));
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(found(static_cast<Eigen::Index>(i), 0), expected[i], 1e-14)
        << i;
  }
}

TEST(MovingMedianTest, IsScipysInsideAndTakesWhatThereIsAtTheEdges) {
  // z the spiky ramp. Inside: scipy.signal.medfilt(z, 5). All of it:
  // [np.median(z[max(0, i-2):i+3]) for i in range(12)], numpy 1.24.2.
  ExpectColumn(MovingMedian(0.2, WindowSide::kCentred,
                            testing::UniformTimes(12), Spiky()),
               {0.1, 0.15, 0.2, 0.4, 0.5, 0.6, 0.5, 0.6, 0.7, 0.9, 0.95, 1.0});
}

TEST(MovingMedianTest, TrailingWindowsKnowNoFuture) {
  // 0.12 s at 25 Hz: the value and the two before.
  ExpectColumn(MovingMedian(0.12, WindowSide::kTrailing,
                            testing::UniformTimes(12), Spiky()),
               {0.0, 0.05, 0.1, 0.2, 0.4, 0.5, 0.5, 0.6, 0.6, 0.7, 0.9, 1.0});
}

TEST(MovingMedianTest, StepsStayAndImpulsesGo) {
  const auto times_s = testing::UniformTimes(21);
  const Samples step = testing::Step(21, 10);
  EXPECT_EQ(MovingMedian(0.2, WindowSide::kCentred, times_s, step), step);
  // A burst of two of five goes, one of three is the majority and stays.
  Samples burst = Samples::Zero(21, 1);
  burst.middleRows(10, 2).setOnes();
  EXPECT_EQ(MovingMedian(0.2, WindowSide::kCentred, times_s, burst).norm(),
            0.0);
  burst(12, 0) = 1.0;
  EXPECT_EQ(MovingMedian(0.2, WindowSide::kCentred, times_s, burst), burst);
}

TEST(MovingMedianTest, UnevenTimeCountsByTime) {
  Samples values(5, 1);
  values << 1.0, 9.0, 2.0, 7.0, 3.0;
  // Within 0.1 s: {1 9}, {1 9 2}, {9 2}, {7 3}, {7 3}.
  ExpectColumn(MovingMedian(0.2, WindowSide::kCentred,
                            {0.0, 0.1, 0.2, 0.5, 0.55}, values),
               {5.0, 2.0, 5.5, 5.0, 5.0});
}

TEST(HampelFilterTest, ReplacesOutliersAlone) {
  // m, s: np.median and 1.482602218505602 * median |w - m| of
  // w = z[max(0, i-3):i+4]; z[i] becomes m where |z[i] - m| > 3 s.
  ExpectColumn(HampelFilter(0.28, 3.0, WindowSide::kCentred,
                            testing::UniformTimes(12), Spiky()),
               {0.0, 0.1, 0.2, 0.4, 0.4, 0.5, 0.6, 0.7, 0.7, 0.9, 1.0, 1.1});
}

TEST(HampelFilterTest, WhereMostAreEqualAnyOtherIsAnOutlier) {
  EXPECT_EQ(HampelFilter(0.28, 3.0, WindowSide::kCentred,
                         testing::UniformTimes(21), testing::Impulse(21, 10))
                .norm(),
            0.0);
}

TEST(HampelMedianTest, IsOneAfterTheOther) {
  ExpectColumn(HampelMedian({}, testing::UniformTimes(12), Spiky()),
               {0.1, 0.15, 0.2, 0.4, 0.4, 0.5, 0.6, 0.7, 0.7, 0.9, 0.95, 1.0});
}

TEST(HampelMedianTest, TheTrailingOneHoldsInGaps) {
  JointSegment segment;
  segment.times_s = testing::UniformTimes(6);
  segment.positions_m.resize(6, 3);
  for (int k = 0; k < 6; ++k) segment.positions_m.row(k).setConstant(k);
  segment.sampled = {1, 1, 0, 0, 0, 1};
  HampelMedianOptions options;
  options.median_window_s = 0.0;  // each value itself
  options.hampel_threshold = 1e9;
  ExpectColumn(HampelMedianFilter(options)(segment).positions_m.col(0),
               {0.0, 1.0, 2.0, 3.0, 4.0, 5.0});
  options.side = WindowSide::kTrailing;
  options.median_window_s = 0.01;
  ExpectColumn(HampelMedianFilter(options)(segment).positions_m.col(0),
               {0.0, 1.0, 1.0, 1.0, 1.0, 5.0});
}

}  // namespace
}  // namespace kinegraph
