#include "core/synthetic/occlusion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kinegraph {
namespace {

using Eigen::Vector3d;

double Distance(const Vector3d& p0, const Vector3d& p1, const Vector3d& q0,
                const Vector3d& q1) {
  return std::sqrt(SquaredSegmentDistance(p0, p1, q0, q1));
}

TEST(SegmentDistance, CrossedParallelAndEnds) {
  const Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  // Crossing lines two apart.
  EXPECT_NEAR(Distance(-x, x, 2 * z - y, 2 * z + y), 2.0, 1e-12);
  // Parallel, side by side and one after the other (gap of 1).
  EXPECT_NEAR(Distance(0 * x, x, y, y + x), 1.0, 1e-12);
  EXPECT_NEAR(Distance(0 * x, x, 2 * x, 3 * x), 1.0, 1e-12);
  // End against middle: the near end is (1, 0, 0), the line x = 4.
  EXPECT_NEAR(Distance(0 * x, x, 4 * x - y, 4 * x + y), 3.0, 1e-12);
  // A point and a segment; two points.
  EXPECT_NEAR(Distance(3 * y, 3 * y, -x, x), 3.0, 1e-12);
  EXPECT_NEAR(Distance(x, x, y, y), std::sqrt(2.0), 1e-12);
}

TEST(SegmentDistance, EqualsTheLeastOverSampledPoints) {
  const Vector3d p0(0.1, -0.4, 0.3), p1(1.2, 0.7, -0.5);
  const Vector3d q0(0.9, -0.2, 0.8), q1(-0.3, 0.6, 0.9);
  double least = 1e9;
  constexpr int kSteps = 400;
  for (int i = 0; i <= kSteps; ++i) {
    for (int k = 0; k <= kSteps; ++k) {
      const Vector3d p = p0 + (p1 - p0) * i / kSteps;
      const Vector3d q = q0 + (q1 - q0) * k / kSteps;
      least = std::min(least, (p - q).norm());
    }
  }
  // The grid is off by at most half a step along each segment, which changes
  // the distance by less than the step squared over the distance.
  EXPECT_NEAR(Distance(p0, p1, q0, q1), least, 1e-4);
  EXPECT_LE(Distance(p0, p1, q0, q1), least + 1e-12);
}

TEST(Obstacle, HidesWhatIsBehindAndNotWhatIsBesideOrBefore) {
  const BodyShape shape = MakeBodyShape(1.75, 1.0);
  Posture posture;
  posture.pelvis_m = {0.0, 0.0, 0.9};
  for (const int side : {kLeft, kRight}) {
    posture.feet[side].ankle_m = {0.0, SignOf(side) * 0.09, 0.07};
  }
  const Obstacle body(CapsulesOf(shape), PlaceBody(shape, posture));
  const Vector3d eye(5.0, 0.0, 1.2);
  EXPECT_TRUE(body.Hides(eye, {-2.0, 0.0, 1.2}));   // behind the trunk
  EXPECT_FALSE(body.Hides(eye, {2.0, 0.0, 1.2}));   // before it
  EXPECT_FALSE(body.Hides(eye, {-2.0, 1.5, 1.2}));  // beside it
  EXPECT_FALSE(body.Hides(eye, {-2.0, 0.0, 3.5}));  // above it
  // Between the legs one sees through.
  EXPECT_FALSE(body.Hides({5.0, 0.0, 0.15}, {-2.0, 0.0, 0.15}));
}

}  // namespace
}  // namespace kinegraph
