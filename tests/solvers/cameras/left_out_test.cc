#include "solvers/cameras/left_out.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

// A person who moves in a circle in view of `views` cameras for eight seconds,
// with white noise and a persistent offset of each joint in each view.
struct Walk {
  CameraRig cameras;
  SceneSegments segments;
  SegmentOptions options;

  Walk(int views, double white_px, double lasting_px) {
    cameras = testing::RingOfCameras(views);
    Random random(5);
    constexpr int kFrames = 200;
    DetectionSequence seen = testing::SeenBy(cameras, kFrames, [](int f) {
      return std::vector<Pose3d>{
          testing::StandingPerson(std::cos(0.04 * f), std::sin(0.04 * f))};
    });
    std::vector<std::vector<Eigen::Vector2d>> lasting(cameras.size());
    for (auto& of_view : lasting) {
      for (int j = 0; j < Coco17().joint_count(); ++j) {
        of_view.emplace_back(lasting_px * random.Normal(),
                             lasting_px * random.Normal());
      }
    }
    FrozenMatches matches;
    matches.people.resize(1);
    for (DetectionFrame& frame : seen.frames) {
      FrozenFrame matched;
      matched.frame = frame.frame;
      matched.written = true;
      for (size_t v = 0; v < cameras.size(); ++v) {
        auto& joints = frame.views[v].detections[0].joints;
        for (size_t j = 0; j < joints.size(); ++j) {
          joints[j].px +=
              lasting[v][j] +
              white_px * Eigen::Vector2d(random.Normal(), random.Normal());
        }
        matched.detections.push_back({static_cast<int>(v), 0});
      }
      matches.people[0].frames.push_back(matched);
    }
    segments = MakeSegments(cameras, seen, matches, options);
  }

  std::optional<FitGain> Gain(const CameraRig& stated) const {
    FreeParameters free;
    free.rotation = true;
    return LeftOutGain(stated, segments, free, NoChanges(stated.size()), {});
  }
};

CameraRig WithTurned(const CameraRig& cameras, size_t view, double rad) {
  std::vector<CameraChange> changes = NoChanges(cameras.size());
  changes[view][kRotationAt] = rad;
  return RefinedCameras(cameras, changes);
}

TEST(LeftOut, CorrectedCameraGainsInHeldOutViews) {
  const Walk walk(5, 1.0, 0.0);
  const auto gain = walk.Gain(WithTurned(walk.cameras, 2, 0.02));
  ASSERT_TRUE(gain.has_value());
  EXPECT_TRUE(gain->certain());
}

// Persistent offsets resemble wrong cameras: cameras fitted to them agree
// better with each other, but a held-out camera shows no gain.
TEST(LeftOut, PersistentDetectorOffsetsGainNothing) {
  const Walk walk(4, 1.0, 8.0);
  const auto gain = walk.Gain(walk.cameras);
  ASSERT_TRUE(gain.has_value());
  EXPECT_FALSE(gain->certain());
}

TEST(LeftOut, NoViewOfThreeCanBeHeldOut) {
  const Walk walk(3, 1.0, 0.0);
  EXPECT_FALSE(walk.Gain(walk.cameras).has_value());
}

}  // namespace
}  // namespace kinegraph
