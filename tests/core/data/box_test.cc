// Bounding boxes of joints.
#include "core/data/box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "core/base/random.h"

namespace kinegraph {
namespace {

Keypoint JointAt(double x_px, double y_px) { return {{x_px, y_px}, 1.0, true}; }

Eigen::AlignedBox2d BoxOf(double left, double top, double right,
                          double bottom) {
  return {Eigen::Vector2d(left, top), Eigen::Vector2d(right, bottom)};
}

TEST(Box, EnclosesTheFoundJoints) {
  std::vector<Keypoint> joints = {JointAt(30.0, 5.0), JointAt(10.0, 25.0),
                                  JointAt(22.0, 45.0), JointAt(-900.0, 900.0)};
  joints.back().found = false;
  const Eigen::AlignedBox2d box = BoxAround(joints);
  EXPECT_EQ(box.min(), Eigen::Vector2d(10.0, 5.0));
  EXPECT_EQ(box.max(), Eigen::Vector2d(30.0, 45.0));
  std::reverse(joints.begin(), joints.end());
  EXPECT_TRUE(BoxAround(joints).isApprox(box));
}

TEST(Box, IsEmptyWithoutJoints) {
  for (const auto& joints :
       {std::vector<Keypoint>(), std::vector<Keypoint>(17)}) {
    EXPECT_TRUE(BoxAround(joints).isEmpty());
    EXPECT_EQ(DiagonalPx(BoxAround(joints)), 0.0);
  }
}

TEST(Box, OneJointGivesAPoint) {
  const Eigen::AlignedBox2d box = BoxAround({JointAt(7.0, 8.0)});
  EXPECT_FALSE(box.isEmpty());
  EXPECT_EQ(DiagonalPx(box), 0.0);
  EXPECT_EQ(GapPx(box, box), 0.0);
}

// A right triangle with legs of 30 and 40.
TEST(Box, DiagonalMatchesHandComputedValues) {
  EXPECT_EQ(DiagonalPx(BoxOf(10.0, 5.0, 40.0, 45.0)), 50.0);
  // A box of zero width.
  EXPECT_EQ(DiagonalPx(BoxOf(10.0, 5.0, 10.0, 45.0)), 40.0);
}

TEST(Box, GapIsTheLargerOfTheGapsAlongXAndY) {
  const Eigen::AlignedBox2d box = BoxOf(0.0, 0.0, 10.0, 20.0);
  // To the right, to the left, below, above and diagonally.
  EXPECT_EQ(GapPx(box, BoxOf(13.0, 5.0, 15.0, 6.0)), 3.0);
  EXPECT_EQ(GapPx(box, BoxOf(-9.0, 5.0, -4.0, 6.0)), 4.0);
  EXPECT_EQ(GapPx(box, BoxOf(5.0, 25.0, 6.0, 30.0)), 5.0);
  EXPECT_EQ(GapPx(box, BoxOf(5.0, -9.0, 6.0, -6.0)), 6.0);
  EXPECT_EQ(GapPx(box, BoxOf(13.0, 27.0, 15.0, 30.0)), 7.0);
  // Touching, overlapping and nested boxes.
  EXPECT_EQ(GapPx(box, BoxOf(10.0, 20.0, 12.0, 22.0)), 0.0);
  EXPECT_EQ(GapPx(box, BoxOf(-5.0, 8.0, 15.0, 9.0)), 0.0);
  EXPECT_EQ(GapPx(box, BoxOf(2.0, 3.0, 4.0, 5.0)), 0.0);
}

TEST(Box, AnEmptyBoxIsFartherThanAnything) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  const Eigen::AlignedBox2d empty;
  for (const double at : {-1e4, 0.0, 1e4}) {
    const Eigen::AlignedBox2d box = BoxOf(at, at, at + 10.0, at + 20.0);
    EXPECT_GE(GapPx(empty, box), kLargest);
    EXPECT_GE(GapPx(box, empty), kLargest);
  }
  EXPECT_GE(GapPx(empty, empty), kLargest);
}

// Compared with the distances of all pairs of joints.
TEST(Box, GapBoundsTheDistanceOfAnyTwoJoints) {
  Random random(11);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Keypoint> a;
    std::vector<Keypoint> b;
    const double aside_px = random.Uniform(-200.0, 200.0);
    for (int j = 0; j < 5; ++j) {
      a.push_back(JointAt(random.Uniform(0, 100), random.Uniform(0, 100)));
      b.push_back(
          JointAt(aside_px + random.Uniform(0, 100), random.Uniform(0, 100)));
    }
    double nearest_px = std::numeric_limits<double>::infinity();
    for (const Keypoint& one : a) {
      for (const Keypoint& other : b) {
        nearest_px = std::min(nearest_px, (one.px - other.px).norm());
      }
    }
    const double gap_px = GapPx(BoxAround(a), BoxAround(b));
    EXPECT_LE(gap_px, nearest_px);
    EXPECT_EQ(gap_px, GapPx(BoxAround(b), BoxAround(a)));
  }
}

}  // namespace
}  // namespace kinegraph
