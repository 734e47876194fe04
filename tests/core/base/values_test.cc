// Statistics, frame clocks and texts.
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/text.h"
#include "core/base/time.h"
#include "core/base/weighted_quantile.h"

namespace kinegraph {
namespace {

TEST(Median, IsTheMiddleOrUpperMiddleValue) {
  EXPECT_EQ(Median({}), 0.0);
  EXPECT_EQ(Median({7.0}), 7.0);
  EXPECT_EQ(Median({9.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(Median({9.0, 1.0, 4.0, 2.0}), 4.0);
}

TEST(WeightedQuantile, IsTheSmallestValueThatReachesTheFraction) {
  const std::vector<WeightedValue> values = {
      {3.0, 1.0}, {1.0, 2.0}, {2.0, 1.0}};
  EXPECT_EQ(WeightedQuantile(values, 0.0), 1.0);
  EXPECT_EQ(WeightedQuantile(values, 0.5), 1.0);
  EXPECT_EQ(WeightedQuantile(values, 0.51), 2.0);
  EXPECT_EQ(WeightedQuantile(values, 0.75), 2.0);
  EXPECT_EQ(WeightedQuantile(values, 1.0), 3.0);
}

TEST(WeightedQuantile, MedianOfEqualHalvesIsTheMidpoint) {
  EXPECT_EQ(WeightedMedian({{7.0, 1.0}}), 7.0);
  // Even count, equal weights: the mean of the middle two, unlike Median.
  EXPECT_EQ(WeightedMedian({{1.0, 1.0}, {2.0, 1.0}, {4.0, 1.0}, {9.0, 1.0}}),
            3.0);
  EXPECT_EQ(WeightedMedian({{1.0, 1.0}, {2.0, 1.0}, {9.0, 1.0}}), 2.0);
  // The first value has half of the weight.
  EXPECT_EQ(WeightedMedian({{1.0, 2.0}, {2.0, 1.0}, {4.0, 1.0}}), 1.5);
  EXPECT_EQ(WeightedMedian({{1.0, 3.0}, {2.0, 1.0}, {4.0, 1.0}}), 1.0);
  // A weight of zero has no effect.
  const std::vector<WeightedValue> values = {
      {1.0, 1.0}, {2.0, 1.0}, {9.0, 1.0}, {50.0, 0.0}};
  EXPECT_EQ(WeightedMedian(values), 2.0);
  EXPECT_EQ(WeightedQuantile(values, 1.0), 9.0);
}

TEST(WeightedQuantile, BinnedQuantileInterpolatesWithinABin) {
  const std::vector<float> weights = {0.0f, 1.0f, 3.0f, 0.0f};
  EXPECT_EQ(BinnedQuantile(weights, 4.0, 0.25), 2.0);
  EXPECT_EQ(BinnedQuantile(weights, 4.0, 0.625), 2.5);
  EXPECT_EQ(BinnedQuantile(weights, 4.0, 1.0), 3.0);
}

TEST(FrameClockTest, ComparesWithHalfAFrameOfTolerance) {
  for (const double rate : {23.976, 25.0, 29.97, 60.0, 120.0}) {
    const FrameClock clock(rate);
    const TimeNs jitter = clock.TimeOf(1) / 3;
    for (int64_t frame = -1000; frame < 1000; ++frame) {
      const TimeNs now = clock.TimeOf(frame);
      for (const TimeNs late : {-jitter, TimeNs{0}, jitter}) {
        EXPECT_TRUE(clock.Less(clock.TimeOf(frame + 2) + late - now, 3.0));
        EXPECT_FALSE(clock.Less(clock.TimeOf(frame + 3) + late - now, 3.0));
      }
    }
  }
}

TEST(FrameClockTest, FramesAndTimeAgree) {
  const FrameClock clock(120.0);
  EXPECT_EQ(clock.TimeOf(120), 1'000'000'000);
  EXPECT_EQ(clock.TimeOf(-60), -500'000'000);
  EXPECT_DOUBLE_EQ(clock.Frames(250'000'000), 30.0);
}

TEST(CountedTest, OneIsSingular) {
  EXPECT_EQ(Counted(0, "frame", "frames"), "0 frames");
  EXPECT_EQ(Counted(1, "frame", "frames"), "1 frame");
  EXPECT_EQ(Counted(2, "image is", "images are"), "2 images are");
}

TEST(EditDistanceTest, CountsInsertionsDeletionsAndReplacements) {
  EXPECT_EQ(EditDistance("", ""), 0u);
  EXPECT_EQ(EditDistance("sigma", "sigma"), 0u);
  EXPECT_EQ(EditDistance("", "tau"), 3u);
  EXPECT_EQ(EditDistance("tau", ""), 3u);
  EXPECT_EQ(EditDistance("alpha", "alpha_2d"), 3u);
  EXPECT_EQ(EditDistance("kitten", "sitting"),
            3u);  // two replaced, one inserted
  EXPECT_EQ(EditDistance("ab", "ba"), 2u) << "a swap counts twice";
}

TEST(Printable, KeepsUtf8Letters) {
  for (const std::string text :
       {"", "camera 1", "Kamera ü", "カメラ", "😀 \u00a0\uffff"}) {
    EXPECT_EQ(Printable(text), text);
  }
}

// Terminals interpret control characters, U+009B among them.
TEST(Printable, ControlCharactersAreReplaced) {
  EXPECT_EQ(Printable("a\nb\x1b[31m\x7f"), "a?b?[31m?");
  EXPECT_EQ(Printable("\xc2\x9b"), "?");
  EXPECT_EQ(Printable(std::string("a\0b", 3)), "a?b");
}

TEST(Printable, InvalidUtf8IsReplaced) {
  EXPECT_EQ(Printable("\x80 \xff \xfe"), "? ? ?");  // invalid first bytes
  EXPECT_EQ(Printable("\xc3 \xe3\x82"), "? ??");    // truncated
  EXPECT_EQ(Printable("\xc0\xaf \xe0\x80\xaf"),
            "?? ???");                               // overlong encodings
  EXPECT_EQ(Printable("\xed\xa0\x80"), "???");       // half of a surrogate pair
  EXPECT_EQ(Printable("\xf4\x90\x80\x80"), "????");  // beyond U+10FFFF
  EXPECT_EQ(Printable("\xf8\x88\x80\x80\x80"), "?????");
}

TEST(Printable, TruncatesBetweenLetters) {
  EXPECT_EQ(Printable("abcdef", 6), "abcdef");
  EXPECT_EQ(Printable("abcdef", 4), "abcd...");
  EXPECT_EQ(Printable("aüüü", 4), "aüü...");
}

}  // namespace
}  // namespace kinegraph
