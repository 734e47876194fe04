// The types of core/data that contain logic.
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
#include "tests/support/standing_person.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

Keypoint Found(double x_px, double confidence) {
  return {{x_px, 50.0}, confidence, true};
}

TEST(MakeObservation, TakesMappedJointsAndCountsAssociationJoints) {
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
  EXPECT_EQ(observation.found_count, 1);  // of association joints
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

TEST(Checks, HeadersAndFramesObeyTheLimitsOfFiles) {
  DetectionHeader header;
  header.skeleton = Coco17();
  const auto refused = [&] {
    return ErrorOf([&] { CheckDetectionHeader(header); });
  };
  EXPECT_THAT(refused(), HasSubstr("views: is empty"));
  header.view_names = {"a", "b"};
  EXPECT_THAT(refused(), IsEmpty());  // a rate of 0 means unknown
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
  EXPECT_THAT(refused(), HasSubstr("'a' appears twice"));
}

TEST(Checks, CameraNamesMustDiffer) {
  CameraRig cameras = testing::RingOfCameras(2);
  EXPECT_THAT(ErrorOf([&] { CheckCameraNames(cameras); }), IsEmpty());
  cameras[1] = cameras[0];
  EXPECT_THAT(ErrorOf([&] { CheckCameraNames(cameras); }),
              HasSubstr("appears twice"));
}

TEST(EditOp, NamesReadBack) {
  for (const EditOp op : {EditOp::kJoin, EditOp::kCut, EditOp::kSwap,
                          EditOp::kDelete, EditOp::kName, EditOp::kUndecided}) {
    EXPECT_EQ(EditOpByName(ToString(op)), op);
  }
  EXPECT_EQ(EditOpByName("merge"), std::nullopt);
}

TEST(NearestAxis, HasASignAndAnAngularLimit) {
  const auto axis = NearestAxis({0.1, -2.0, 0.1}, 10.0);
  ASSERT_TRUE(axis.has_value());
  EXPECT_EQ(*axis, Eigen::Vector3d(0.0, -1.0, 0.0));
  // The space diagonal is 54.7 degrees off every axis.
  EXPECT_FALSE(NearestAxis({1.0, 1.0, 1.0}, 54.0).has_value());
  EXPECT_TRUE(NearestAxis({1.0, 1.0, 1.0}, 55.0).has_value());
}

// Poses of one person in a rotated world.
class People {
 public:
  // Stands at (x, y), rotated about y; at -90 degrees the person lies on the
  // back.
  void Add(double x_m, double y_m, double turn_deg = 0.0,
           double height_m = 0.0) {
    testing::PosedPerson person;
    Add(person, x_m, y_m, turn_deg, height_m);
  }
  void Add(const testing::PosedPerson& posed, double x_m, double y_m,
           double turn_deg, double height_m) {
    const Eigen::AngleAxisd turn(turn_deg * 3.14159265358979323846 / 180.0,
                                 Eigen::Vector3d::UnitY());
    PersonPose pose = posed.pose();
    for (Joint3d& joint : pose.joints) {
      joint.position_m =
          turn * joint.position_m + Eigen::Vector3d(x_m, y_m, height_m);
    }
    stance_.See(pose);
  }
  const Stance& stance() const { return stance_; }

 private:
  Stance stance_{Body25()};
};

testing::PosedPerson SittingOnTheFloor() {
  testing::PosedPerson person;
  for (const std::string side : {"l_", "r_"}) {
    for (const char* joint : {"shoulder", "elbow", "wrist"}) {
      person.Put(side + joint,
                 person.At(side + joint) - Eigen::Vector3d(0.0, 0.0, 0.9));
    }
    const double y = person.At(side + "hip").y();
    person.Put(side + "hip", {0.0, y, 0.1});
    person.Put(side + "knee", {0.5, y, 0.1});
    person.Put(side + "ankle", {0.9, y, 0.1});
    person.Put(side + "heel", {0.95, y, 0.05});
    person.Put(side + "big_toe", {0.95, y, 0.25});
  }
  return person;
}

TEST(Stance, AStandingPersonDefinesUpInAnyWorld) {
  People people;
  for (int k = 0; k < 50; ++k) people.Add(0.05 * k, 1.0);
  EXPECT_EQ(NearestAxis(*people.stance().Up(), 1.0), Eigen::Vector3d::UnitZ());
  // The same in a world with x up.
  People turned;
  for (int k = 0; k < 50; ++k) turned.Add(2.0, 0.05 * k, 90.0, 2.0);
  EXPECT_EQ(NearestAxis(*turned.stance().Up(), 1.0), Eigen::Vector3d::UnitX());
}

// A lying person and a world on its side look the same unless the file states
// the upward direction. That of the cameras does not decide.
TEST(Stance, ALyingPersonLeavesUpUndetermined) {
  for (const double height_m : {0.2, 0.7}) {
    People people;
    for (int k = 0; k < 50; ++k) people.Add(0.5, 0.002 * k, -90.0, height_m);
    EXPECT_FALSE(people.stance().Up().has_value()) << height_m;
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
    EXPECT_EQ(people.stance().Up({z}), z);
    EXPECT_FALSE(people.stance().Up({std::nullopt, z}).has_value())
        << "the cameras may be turned";
    EXPECT_FALSE(people.stance().UpUnlike(z, {z}).has_value());
  }
}

// A person walks for a fifth of the time and lies for the rest; the height of
// the floor is constant only along z.
TEST(Stance, TheFloorOutweighsALyingPerson) {
  for (const double height_m : {0.2, 0.6}) {
    People people;
    for (int k = 0; k < 20; ++k) people.Add(0.2 * k, 0.05 * k);
    for (int k = 0; k < 80; ++k) people.Add(0.5, 0.0, 90.0, height_m);
    const auto up = people.stance().Up();
    ASSERT_TRUE(up.has_value()) << height_m;
    EXPECT_EQ(NearestAxis(*up, 5.0), Eigen::Vector3d::UnitZ()) << height_m;
    // Also against the file's axis.
    EXPECT_EQ(NearestAxis(*people.stance().Up({Eigen::Vector3d::UnitX()}), 5.0),
              Eigen::Vector3d::UnitZ());
  }
}

TEST(Stance, APersonSittingOnTheFloorDefinesUp) {
  People people;
  for (int k = 0; k < 50; ++k) {
    people.Add(SittingOnTheFloor(), 0.3, 0.001 * k, 0.0, 0.0);
  }
  EXPECT_EQ(people.stance().Up(), Eigen::Vector3d::UnitZ());
}

// The stated axis z is wrong: a person who moves along it is not lying.
TEST(Stance, AWalkingPersonOverridesTheStatedAxis) {
  People people;
  for (int k = 0; k < 50; ++k) people.Add(0.0, 1.0, 90.0, 3.0 + 0.04 * k);
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  EXPECT_EQ(NearestAxis(*people.stance().Up({z}), 1.0),
            Eigen::Vector3d::UnitX());
}

}  // namespace
}  // namespace kinegraph
