#include "solvers/session/presence.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

constexpr double kLow = 0.02;  // in the confidence bin from 0.01 to 0.03

// 100 frames of a person in four views; a third of the joints have a low
// confidence and, if `astray`, random positions in the image.
double LeastConfidence(bool astray) {
  const CameraRig cameras = testing::RingOfCameras(4);
  Random random(3);
  PresenceLearner learner(cameras);
  for (int f = 0; f < 100; ++f) {
    DetectionFrame seen = testing::FrameSeenBy(
        cameras, f, {testing::StandingPerson(0.01 * f, 0.2)});
    for (ViewDetections& view : seen.views) {
      for (Keypoint& joint : view.detections[0].joints) {
        joint.confidence = 0.9;
        if (!random.Chance(1.0 / 3.0)) continue;
        joint.confidence = kLow;
        if (!astray) continue;
        joint.px = {random.Uniform(0.0, 1920.0), random.Uniform(0.0, 1080.0)};
      }
    }
    learner.See(seen);
  }
  return learner.LeastConfidence();
}

TEST(Presence, LowConfidencesWithRandomPositionsAreAbsent) {
  EXPECT_EQ(LeastConfidence(/*astray=*/true), 0.03);
}

TEST(Presence, LowConfidencesWithCorrectPositionsArePresent) {
  EXPECT_EQ(LeastConfidence(/*astray=*/false), 0.0);
}

TEST(Presence, NothingIsLearntWithoutFrames) {
  const CameraRig cameras = testing::RingOfCameras(4);
  EXPECT_EQ(PresenceLearner(cameras).LeastConfidence(), 0.0);
}

TEST(Presence, AbsentJointsAreMarkedNotFound) {
  DetectionFrame frame;
  frame.views.resize(1);
  frame.views[0].detections.resize(1);
  frame.views[0].detections[0].joints = {{{1.0, 1.0}, 0.029, true},
                                         {{1.0, 1.0}, 0.03, true}};
  DropAbsentJoints(0.03, &frame);
  const auto& joints = frame.views[0].detections[0].joints;
  EXPECT_FALSE(joints[0].found);
  EXPECT_TRUE(joints[1].found);
}

}  // namespace
}  // namespace kinegraph
