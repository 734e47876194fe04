#include "core/io/text/names.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

TEST(LastInteger, TakesTheLastRunOfDigits) {
  EXPECT_EQ(LastInteger("cam01_json"), 1);
  EXPECT_EQ(LastInteger("00_16"), 16);
  EXPECT_EQ(LastInteger("Camera0"), 0);
  EXPECT_EQ(LastInteger("left"), std::nullopt);
  EXPECT_EQ(LastInteger(""), std::nullopt);
  EXPECT_EQ(LastInteger("a000000000000000000000000000012"), 12);
  EXPECT_EQ(LastInteger("a1234567890123456789"), std::nullopt);
}

TEST(FrameOfFileName, IsTheIntegerBeforeKeypoints) {
  EXPECT_EQ(FrameOfFileName("cam0_000000000300_keypoints.json"), 300);
  EXPECT_EQ(FrameOfFileName("cam01.0042.json"), 42);
  EXPECT_EQ(FrameOfFileName("take_7_keypoints_v2.json"), 7);
  EXPECT_EQ(FrameOfFileName("body3DScene_00010600.json"), 10600);
  EXPECT_EQ(FrameOfFileName("meta.json"), std::nullopt);
}

TEST(NaturalLess, ComparesNumbersAsNumbers) {
  EXPECT_TRUE(NaturalLess("cam2", "cam10"));
  EXPECT_FALSE(NaturalLess("cam10", "cam2"));
  EXPECT_TRUE(NaturalLess("_3", "_16"));
  EXPECT_TRUE(NaturalLess("a", "b"));
  EXPECT_TRUE(NaturalLess("cam", "cam0"));
  EXPECT_FALSE(NaturalLess("cam1", "cam1"));
  // A strict order: names that differ only in zeros are not equal.
  EXPECT_NE(NaturalLess("cam1", "cam01"), NaturalLess("cam01", "cam1"));
  EXPECT_TRUE(NaturalLess("1_01_b", "01_1_c"));
}

}  // namespace
}  // namespace kinegraph
