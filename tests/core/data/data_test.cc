// The values of core/data that decide something.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/data/identity_edit.h"
#include "core/data/observation.h"
#include "core/data/stance.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

Keypoint Found(double x_px, double confidence) {
  return {{x_px, 50.0}, confidence, true};
}

TEST(MakeObservation, TakesJointsByNameAndCountsThoseThatCount) {
  Detection detection;
  detection.index_in_file = 3;
  detection.joints = {Found(10.0, 0.2), Found(20.0, 0.6), Keypoint()};
  const Camera camera = testing::RingOfCameras(1).front();
  Observation observation;
  // The tracks' joints are the detection's second, none, first and third.
  MakeObservation(detection, {1, -1, 0, 2}, {0, 1, 3}, camera, 2, 77,
                  &observation);
  EXPECT_EQ(observation.view_idx, 2);
  EXPECT_EQ(observation.detection_idx, 3);
  EXPECT_EQ(observation.capture_time, 77);
  ASSERT_EQ(observation.joints.size(), 4u);
  EXPECT_EQ(observation.joints[0].px.x(), 20.0);
  EXPECT_FALSE(observation.joints[1].found);
  EXPECT_EQ(observation.joints[2].px.x(), 10.0);
  EXPECT_FALSE(observation.joints[3].found);
  EXPECT_EQ(observation.found_count, 1);  // of those that count
  EXPECT_EQ(observation.mean_confidence, 0.6);
}

TEST(EditOp, NamesReadBack) {
  for (const EditOp op : {EditOp::kJoin, EditOp::kCut, EditOp::kSwap,
                          EditOp::kDelete, EditOp::kName, EditOp::kUndecided}) {
    EXPECT_EQ(EditOpByName(ToString(op)), op);
  }
  EXPECT_EQ(EditOpByName("merge"), std::nullopt);
}

TEST(NearestAxis, HasASignAndALimit) {
  const auto axis = NearestAxis({0.1, -2.0, 0.1}, 10.0);
  ASSERT_TRUE(axis.has_value());
  EXPECT_EQ(*axis, Eigen::Vector3d(0.0, -1.0, 0.0));
  // The space diagonal is 54.7 degrees off every axis.
  EXPECT_FALSE(NearestAxis({1.0, 1.0, 1.0}, 54.0).has_value());
  EXPECT_TRUE(NearestAxis({1.0, 1.0, 1.0}, 55.0).has_value());
}

}  // namespace
}  // namespace kinegraph
