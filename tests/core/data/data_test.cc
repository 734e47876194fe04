// The values of core/data that decide something.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/data/checks.h"
#include "core/data/identity_edit.h"
#include "core/data/limits.h"
#include "core/data/observation.h"
#include "core/data/stance.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

std::string ErrorOf(const std::function<void()>& check) {
  try {
    check();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Checks, HeadersAndFramesKeepTheBoundsOfFiles) {
  DetectionHeader header;
  header.skeleton = Coco17();
  const auto refused = [&] {
    return ErrorOf([&] { CheckDetectionHeader(header); });
  };
  EXPECT_THAT(refused(), HasSubstr("views: is empty"));
  header.view_names = {"a", "b"};
  EXPECT_THAT(refused(), IsEmpty());  // a rate of 0 is not known
  for (const double hz : {1e300, -1.0, kNan}) {
    header.frame_rate_hz = hz;
    EXPECT_THAT(refused(), HasSubstr("frame_rate")) << hz;
  }
  header.frame_rate_hz = kMaxFrameRate_hz;
  EXPECT_THAT(refused(), IsEmpty());
  DetectionFrame frame;
  frame.views.resize(2);
  const auto frame_refused = [&] {
    return ErrorOf([&] { CheckDetectionFrame(header, frame); });
  };
  frame.frame = kMaxFrame;
  EXPECT_THAT(frame_refused(), IsEmpty());
  for (const int64_t number : {kMaxFrame + 1, int64_t{-1}}) {
    frame.frame = number;
    EXPECT_THAT(frame_refused(), HasSubstr("out of range"));
  }
  EXPECT_EQ(CheckedTime(-kMaxTime_s, "time"), FromSeconds(-kMaxTime_s));
  for (const double seconds : {1.001 * kMaxTime_s, kNan}) {
    EXPECT_THAT(ErrorOf([&] { CheckedTime(seconds, "time"); }),
                HasSubstr("time: is out of range"));
  }
  header.view_names = {"a", "a"};
  EXPECT_THAT(refused(), HasSubstr("'a' stands there twice"));
}

TEST(Checks, EachCameraHasANameOfItsOwn) {
  CameraRig cameras = testing::RingOfCameras(2);
  EXPECT_THAT(ErrorOf([&] { CheckCameraNames(cameras); }), IsEmpty());
  cameras[1] = cameras[0];
  EXPECT_THAT(ErrorOf([&] { CheckCameraNames(cameras); }),
              HasSubstr("stands there twice"));
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
