#include "core/evaluation/centres.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

TEST(ReducedToCentresTest, ReducesOnlyIfExactlyOneSideIsACentroid) {
  const Skeleton centroid("centroid", {"middle"}, {});
  const Skeleton box("box", {"top", "bottom"}, {});
  const auto poses = [](const Skeleton& skeleton, const Pose3d& pose) {
    return Tracks({Frame(4, {Person(7, pose)})}, skeleton);
  };
  const TrackSequence point = poses(centroid, {Observed(1.0, 2.0, 0.5)});
  const TrackSequence boxes = poses(box, {Observed(1.0, 2.0, 2.0), Joint3d{}});
  EXPECT_FALSE(ReducedToCentres(boxes, boxes).has_value());
  EXPECT_FALSE(ReducedToCentres(point, point).has_value());

  const auto centres = ReducedToCentres(boxes, point);
  ASSERT_TRUE(centres.has_value());
  EXPECT_EQ(centres->a.header.skeleton, centres->b.header.skeleton);
  EXPECT_EQ(centres->note,
            "people are compared by their centres: 'middle' and the mean of "
            "all joints");
  EXPECT_EQ(centres->a.frames[0].frame, 4);
  EXPECT_EQ(centres->a.frames[0].time, boxes.frames[0].time);
  const PersonPose& person = centres->a.frames[0].people[0];
  EXPECT_EQ(person.id, TrackId(7));
  // The bottom is missing: the mean of the remaining joints.
  EXPECT_EQ(person.joints[0].position_m.z(), 2.0);
  EXPECT_EQ(person.joints[0].status, JointStatus::kObserved);
  EXPECT_EQ(centres->b.frames[0].people[0].joints[0].position_m.z(), 0.5);
}

TEST(ReducedToCentresTest, HipsAreTheCentreOfABody) {
  const TrackSequence point =
      Tracks({Frame(0, {Person(0, {Observed(0.0, 0.0, 0.0)})})},
             Skeleton("centroid", {"middle"}, {}));
  Pose3d pose = StandingTum14(3.0, 4.0);
  const auto centre = [&]() {
    const auto centres = ReducedToCentres(point, Alone(pose));
    return centres->b.frames[0].people[0].joints[0];
  };
  EXPECT_EQ(centre().position_m, Eigen::Vector3d(3.0, 4.0, 1.0));
  EXPECT_THAT(ReducedToCentres(point, Alone(pose))->note,
              ::testing::EndsWith("and the middle of the hips"));
  // One hip alone does not define the centre.
  pose[2] = Joint3d{};
  EXPECT_EQ(centre().position_m, *MeanPosition(pose));
  for (Joint3d& joint : pose) {
    if (joint.present()) joint.status = JointStatus::kInferred;
  }
  EXPECT_EQ(centre().status, JointStatus::kInferred);
  pose.assign(pose.size(), Joint3d{});
  EXPECT_FALSE(centre().present());
}

}  // namespace
}  // namespace kinegraph::testing
