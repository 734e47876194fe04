#include "core/synthetic/body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

Posture Standing(const BodyShape& shape) {
  Posture posture;
  posture.pelvis_m = {0.0, 0.0, 0.96 * shape.leg() + shape.ankle_height};
  for (const int side : {kLeft, kRight}) {
    posture.feet[side].ankle_m = {0.0, SignOf(side) * shape.hip_half_width,
                                  shape.ankle_height};
  }
  return posture;
}

std::vector<Vector3d> Joints(const BodyShape& shape, const Skeleton& skeleton,
                             const Posture& posture) {
  const BodyPose pose = PlaceBody(shape, posture);
  std::vector<Vector3d> joints;
  for (const BodyPoint& point : PointsOf(shape, skeleton)) {
    joints.push_back(PositionOf(point, pose));
  }
  return joints;
}

TEST(Body, StandsUprightWithLeftOnTheLeft) {
  const BodyShape shape = MakeBodyShape(1.75, 1.0);
  const Skeleton& skeleton = Body25B();
  const auto joints = Joints(shape, skeleton, Standing(shape));
  auto at = [&](const char* name) { return joints[skeleton.IndexOf(name)]; };
  // Forward is x, left is y; the person has the requested height except for the
  // slight bend of the knees (4 % of the legs).
  EXPECT_NEAR(at("head_top").z(), 1.75, 0.04 * shape.leg() + 1e-9);
  EXPECT_GT(at("l_shoulder").y(), 0.1);
  EXPECT_LT(at("r_shoulder").y(), -0.1);
  EXPECT_GT(at("nose").x(), at("l_ear").x());
  EXPECT_GT(at("l_big_toe").x(), at("l_heel").x());
  EXPECT_GT(at("l_knee").x(), at("l_hip").x()) << "knees bend forwards";
  EXPECT_LT(at("l_big_toe").y(), at("l_small_toe").y()) << "big toe inside";
  EXPECT_NEAR(at("l_big_toe").z(), 0.0, 1e-12) << "toes on the floor";
  EXPECT_LT(at("l_wrist").z(), at("l_elbow").z()) << "arms hang";
}

TEST(Body, MirroredPostureGivesMirroredJoints) {
  const BodyShape shape = MakeBodyShape(1.6, 1.02);
  Posture posture = Standing(shape);
  posture.arms[kLeft] = {0.7, 0.4, 0.2, 1.1};
  posture.arms[kRight] = {-0.2, 0.1, 0.0, 0.3};
  posture.feet[kLeft].ankle_m += Vector3d(0.3, 0.02, 0.1);
  posture.feet[kLeft].pitch = 0.4;
  posture.twist = 0.2;
  Posture mirrored = posture;
  std::swap(mirrored.arms[kLeft], mirrored.arms[kRight]);
  std::swap(mirrored.feet[kLeft], mirrored.feet[kRight]);
  mirrored.twist = -posture.twist;
  for (FootPosture& foot : mirrored.feet) foot.ankle_m.y() *= -1.0;
  const Skeleton& skeleton = Body25();
  const auto joints = Joints(shape, skeleton, posture);
  const auto others = Joints(shape, skeleton, mirrored);
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    Vector3d expected = joints[skeleton.mirror(j)];
    expected.y() *= -1.0;
    EXPECT_LT((others[j] - expected).norm(), 1e-12) << skeleton.joints()[j];
  }
}

TEST(Body, ArmAnglesMatchAnatomicalNames) {
  const BodyShape shape = MakeBodyShape(1.75, 1.0);
  const Skeleton& skeleton = Coco17();
  Posture posture = Standing(shape);
  posture.arms[kLeft].flexion = M_PI / 2;     // straight ahead
  posture.arms[kRight].abduction = M_PI / 2;  // straight to the side
  const auto joints = Joints(shape, skeleton, posture);
  auto at = [&](const char* name) { return joints[skeleton.IndexOf(name)]; };
  const double arm = shape.upper_arm + shape.forearm;
  const Vector3d ahead = at("l_wrist") - at("l_shoulder");
  EXPECT_LT((ahead - Vector3d(arm, 0.0, 0.0)).norm(), 1e-12);
  const Vector3d aside = at("r_wrist") - at("r_shoulder");
  EXPECT_LT((aside - Vector3d(0.0, -arm, 0.0)).norm(), 1e-12);
}

TEST(Body, FeetReachTargetsAndLegsKeepLength) {
  const BodyShape shape = MakeBodyShape(1.8, 0.98);
  const Skeleton& skeleton = Coco17();
  for (const double forward : {0.0, 0.2, 0.4, 0.8, 3.0}) {
    Posture posture = Standing(shape);
    posture.feet[kLeft].ankle_m.x() = forward;
    const auto joints = Joints(shape, skeleton, posture);
    const Vector3d hip = joints[skeleton.IndexOf("l_hip")];
    const Vector3d knee = joints[skeleton.IndexOf("l_knee")];
    const Vector3d ankle = joints[skeleton.IndexOf("l_ankle")];
    EXPECT_NEAR((hip - knee).norm(), shape.thigh, 1e-12);
    EXPECT_NEAR((knee - ankle).norm(), shape.shank, 1e-12);
    const Vector3d wanted = posture.feet[kLeft].ankle_m;
    // Up to 0.964 of the leg's length targets are reached; beyond, the distance
    // is limited smoothly (ReachableDistance in body.cc).
    if ((wanted - hip).norm() < 0.96 * shape.leg()) {
      EXPECT_LT((ankle - wanted).norm(), 1e-12);
    } else {
      EXPECT_LT((ankle - hip).norm(), shape.leg());
    }
  }
}

TEST(Body, KnowsTheJointsOfAllBuiltInSkeletons) {
  const BodyShape shape = MakeBodyShape(1.7, 1.0);
  for (const std::string& name : SkeletonNames()) {
    const Skeleton& skeleton = *FindSkeleton(name);
    const auto points = PointsOf(shape, skeleton);
    EXPECT_EQ(points.size(), skeleton.joints().size()) << name;
  }
}

TEST(Body, PlacesWholeBodyPointsOnHeadAndHands) {
  const BodyShape shape = MakeBodyShape(1.7, 1.0);
  const Skeleton skeleton = WholeBody133();
  ASSERT_EQ(skeleton.joint_count(), 133);
  EXPECT_EQ(skeleton.association_joints().size(), 17u);
  const auto joints = Joints(shape, skeleton, Standing(shape));
  for (int j = 23; j < 133; ++j) {
    const std::string& name = skeleton.joints()[j];
    const bool face = j < 91;
    const char* centre = face ? "nose" : (j < 112 ? "l_wrist" : "r_wrist");
    // A face is within 15 cm of the nose, a hand within 20 cm of its wrist.
    EXPECT_LT((joints[j] - joints[skeleton.IndexOf(centre)]).norm(),
              face ? 0.15 : 0.2)
        << name;
    for (int k = 23; k < j; ++k) {
      EXPECT_GT((joints[j] - joints[k]).norm(), 1e-4)
          << name << " and " << skeleton.joints()[k];
    }
  }
}

TEST(Body, ErrorNamesUnknownJoint) {
  const Skeleton skeleton("mine", {"nose", "tail"}, {});
  try {
    PointsOf(MakeBodyShape(1.7, 1.0), skeleton);
    FAIL() << "no error";
  } catch (const OptionError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("'tail'"));
  }
}

double Distance(const Vector3d& p0, const Vector3d& p1, const Vector3d& q0,
                const Vector3d& q1) {
  return std::sqrt(SquaredSegmentDistance(p0, p1, q0, q1));
}

TEST(SegmentDistance, MatchesHandComputedValues) {
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

TEST(SegmentDistance, MatchesMinimumOverSampledPoints) {
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
  // The nearest grid points are at most half a step away along each segment,
  // which changes the distance by less than the step squared over the distance.
  EXPECT_NEAR(Distance(p0, p1, q0, q1), least, 1e-4);
  EXPECT_LE(Distance(p0, p1, q0, q1), least + 1e-12);
}

TEST(Obstacle, HidesOnlyWhatIsBehind) {
  const BodyShape shape = MakeBodyShape(1.75, 1.0);
  const Obstacle body = ObstacleOf(shape, PlaceBody(shape, Standing(shape)));
  const Vector3d eye(5.0, 0.0, 1.2);
  EXPECT_TRUE(body.Hides(eye, {-2.0, 0.0, 1.2}));   // behind the trunk
  EXPECT_FALSE(body.Hides(eye, {2.0, 0.0, 1.2}));   // in front of it
  EXPECT_FALSE(body.Hides(eye, {-2.0, 1.5, 1.2}));  // beside it
  EXPECT_FALSE(body.Hides(eye, {-2.0, 0.0, 3.5}));  // above it
  // The space between the legs does not occlude.
  EXPECT_FALSE(body.Hides({5.0, 0.0, 0.15}, {-2.0, 0.0, 0.15}));
}

}  // namespace
}  // namespace kinegraph
