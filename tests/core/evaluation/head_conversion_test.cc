#include <gtest/gtest.h>

#include <cmath>

#include "core/evaluation/pcp.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;
using testing::Observed;
using testing::StandingTum14;

constexpr int kBottom = 12;
constexpr int kTop = 13;

// Facing +y. m = (0, 0, 1.5), n = (0, 0.2, 1.7), e = (0, 0.1, 1.7).
Pose3d CocoPerson() {
  Pose3d pose(17);
  const std::vector<int> coco_of_tum = {16, 14, 12, 11, 13, 15,
                                        10, 8,  6,  5,  7,  9};
  const Pose3d body = StandingTum14();
  for (int j = 0; j < 12; ++j) pose[coco_of_tum[j]] = body[j];
  pose[0] = Observed(0.0, 0.2, 1.7);
  pose[1] = Observed(-0.03, 0.18, 1.75);
  pose[2] = Observed(0.03, 0.18, 1.75);
  pose[3] = Observed(-0.08, 0.1, 1.7);
  pose[4] = Observed(0.08, 0.1, 1.7);
  return pose;
}

struct Expected {
  HeadConversion conversion;
  Vector3d bottom;
  Vector3d top;
};

void ExpectNear(const Vector3d& found, const Vector3d& expected) {
  // A handful of roundings of numbers below 2.
  EXPECT_LT((found - expected).norm(), 1e-14)
      << found.transpose() << " instead of " << expected.transpose();
}

TEST(HeadConversionTest, ValuesByHand) {
  // Face direction of 4d: (0, 0, 1.5 - 1) x (0.5, 0, 0) points along +y.
  const std::vector<Expected> all = {
      {HeadConversion::kChu, {0, 0.08, 1.62}, {0, 0.1, 1.8}},
      {HeadConversion::kMvpose, {0, 0.1, 1.6}, {0, 0.15, 1.8}},
      {HeadConversion::kVoxelposeCampus, {0, 0.05, 1.6}, {0, 0.15, 1.8}},
      {HeadConversion::kVoxelposeShelf, {0, 0.0875, 1.6}, {0, 0.15, 1.8}},
      {HeadConversion::k4d, {0, 0.05, 1.6}, {0, 0.175, 1.745}},
      {HeadConversion::kRaw, {0, 0, 1.5}, {0, 0.2, 1.7}},
  };
  for (const Expected& expected : all) {
    SCOPED_TRACE(ToString(expected.conversion));
    const Pose3d pose =
        Tum14Converter(Coco17(), expected.conversion)(CocoPerson());
    ASSERT_EQ(pose.size(), 14u);
    ExpectNear(pose[kBottom].position_m, expected.bottom);
    ExpectNear(pose[kTop].position_m, expected.top);
    for (int j = 0; j < 12; ++j) {
      EXPECT_EQ(pose[j].position_m, StandingTum14()[j].position_m);
      EXPECT_TRUE(pose[j].present());
    }
  }
}

TEST(HeadConversionTest, WeightsAreOfWorldAxes) {
  // The same head turned to +x gets other factors: 0.78 instead of 0.5.
  Pose3d pose = CocoPerson();
  pose[0] = Observed(0.2, 0.0, 1.7);
  const Pose3d converted = Tum14Converter(Coco17(), HeadConversion::kChu)(pose);
  ExpectNear(converted[kTop].position_m, {0.156, 0, 1.8});
  ExpectNear(converted[kBottom].position_m, {0.06, 0, 1.62});
}

TEST(HeadConversionTest, FourDUsesThePosesOwnNeckAndMidHip) {
  Pose3d pose(FourDA19().joint_count());
  const std::vector<int> coco = MapByName(Coco17(), FourDA19());
  for (int j = 0; j < FourDA19().joint_count(); ++j) {
    if (coco[j] >= 0) pose[j] = CocoPerson()[coco[j]];
  }
  const int neck = FourDA19().IndexOf("neck");
  const int mid_hip = FourDA19().IndexOf("mid_hip");
  const Tum14Converter convert(FourDA19(), HeadConversion::k4d);
  ExpectNear(convert(pose)[kTop].position_m, {0, 0.175, 1.745});  // from m
  // A trunk leaning back to 3:4 turns the face up: (0, -0.3, 0.4) x (1, 0, 0)
  // = (0, 0.4, 0.3), of length 0.5.
  pose[mid_hip] = Observed(0.0, 0.0, 1.0);
  pose[neck] = Observed(0.0, -0.3, 1.4);
  ExpectNear(convert(pose)[kTop].position_m,
             {0, 0.05 + 0.125 * 0.8, 1.6 + 0.125 * 0.6 + 0.145});
}

TEST(HeadConversionTest, MissingJointsStayMissing) {
  Pose3d pose = CocoPerson();
  pose[0] = Joint3d{};   // nose
  pose[15] = Joint3d{};  // l_ankle
  const auto convert = [&](HeadConversion conversion) {
    return Tum14Converter(Coco17(), conversion)(pose);
  };
  for (const HeadConversion conversion :
       {HeadConversion::kChu, HeadConversion::kMvpose,
        HeadConversion::kVoxelposeShelf}) {
    EXPECT_FALSE(convert(conversion)[kBottom].present());
    EXPECT_FALSE(convert(conversion)[kTop].present());
    EXPECT_FALSE(convert(conversion)[5].present());
    EXPECT_TRUE(convert(conversion)[4].present());
  }
  EXPECT_TRUE(convert(HeadConversion::k4d)[kTop].present());
  EXPECT_TRUE(convert(HeadConversion::kRaw)[kBottom].present());
  EXPECT_FALSE(convert(HeadConversion::kRaw)[kTop].present());
}

TEST(HeadConversionTest, AComputedJointIsAsGoodAsItsWorstSource) {
  Pose3d pose = CocoPerson();
  pose[5].status = JointStatus::kInferred;  // l_shoulder
  const Pose3d converted = Tum14Converter(Coco17(), HeadConversion::kChu)(pose);
  EXPECT_EQ(converted[kTop].status, JointStatus::kInferred);
  EXPECT_EQ(converted[8].status, JointStatus::kObserved);
}

TEST(HeadConversionTest, SkeletonWithoutEarsHasNoEarHead) {
  const Skeleton body("body", {"nose", "l_shoulder", "r_shoulder"}, {});
  const Pose3d pose = {Observed(0, 0.2, 1.7), Observed(-0.2, 0, 1.5),
                       Observed(0.2, 0, 1.5)};
  const auto convert = [&](HeadConversion conversion) {
    return Tum14Converter(body, conversion)(pose);
  };
  EXPECT_FALSE(convert(HeadConversion::kVoxelposeCampus)[kTop].present());
  EXPECT_FALSE(convert(HeadConversion::k4d)[kTop].present());
  EXPECT_TRUE(convert(HeadConversion::kChu)[kTop].present());
  EXPECT_FALSE(convert(HeadConversion::kChu)[0].present());
}

TEST(HeadConversionTest, GroundTruthKeepsItsOwnHead) {
  const Pose3d pose =
      Tum14Converter(Tum14(), HeadConversion::kChu)(StandingTum14());
  EXPECT_EQ(pose[kBottom].position_m, Vector3d(0, 0, 1.5));
  EXPECT_EQ(pose[kTop].position_m, Vector3d(0, 0, 1.75));
}

TEST(HeadConversionTest, ByName) {
  EXPECT_EQ(HeadConversionByName("voxelpose", true),
            HeadConversion::kVoxelposeCampus);
  EXPECT_EQ(HeadConversionByName("voxelpose", false),
            HeadConversion::kVoxelposeShelf);
  EXPECT_EQ(HeadConversionByName("4d", false), HeadConversion::k4d);
  EXPECT_FALSE(HeadConversionByName("nose", false).has_value());
}

}  // namespace
}  // namespace kinegraph
