#include "core/synthetic/recorded_people.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/synthetic/scene.h"

namespace kinegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using People = std::vector<std::shared_ptr<const Actor>>;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// Simulated walkers with rigid bones, at 30 Hz.
Scene Walkers(int people) {
  SceneOptions options;
  options.seed = 4;
  options.people = people;
  options.duration_s = 4.0;
  options.frame_rate_hz = 30.0;
  options.motion.visitors = 0.0;
  options.motion.sitting = 0.0;
  return MakeScene(options);
}

// Poses of simulated walkers as a recorded clip.
MotionClip Walk(int people = 1) {
  return {"walk.jsonl", TruthOf(Walkers(people))};
}

// Largest difference between the lengths of a bone in two poses.
double BoneChange(const Pose3d& a, const Pose3d& b) {
  const auto length = [](const Pose3d& pose, const Bone& bone) {
    return (pose[bone.a].position_m - pose[bone.b].position_m).norm();
  };
  double worst = 0.0;
  for (const Bone& bone : Coco17().bones()) {
    worst = std::max(worst, std::abs(length(a, bone) - length(b, bone)));
  }
  return worst;
}

double Apart(const Joint3d& a, const Joint3d& b) {
  return (a.position_m - b.position_m).norm();
}

People Make(const RecordedPeopleOptions& options,
            const std::vector<MotionClip>& clips, ClipRoom room = {}) {
  return MakeRecordedPeople(options, clips, Coco17(), room);
}

// Options that place one clip at the origin, not rotated.
RecordedPeopleOptions InPlace() {
  RecordedPeopleOptions options;
  options.x_m = options.y_m = options.turn_deg = {0.0};
  return options;
}

// Bones keep their length between frames, too. The error of a cubic spline is
// at most 5/384 h^4 times the fourth derivative (Hall and Meyer 1976). A wrist
// half a metre from the shoulder that swings at 2 Hz with 1 rad has 0.5 (4
// pi)^4 = 12500 m/s^4: 0.2 mm at h = 1/30 s; a bone has two ends.
TEST(RecordedPeople, PassThroughTheRecordedJoints) {
  const MotionClip clip = Walk();
  const People people = Make(InPlace(), {clip});
  ASSERT_EQ(people.size(), 1u);
  const Pose3d& recorded = clip.tracks.frames[0].people[0].joints;
  for (double t = 0.0; t < 3.96; t += 0.007) {
    EXPECT_LT(BoneChange(people[0]->PoseAt(t), recorded), 4e-4) << t;
  }
  // Without rotation, all joints are moved by the same horizontal vector.
  const Vector3d moved =
      people[0]->PoseAt(0.0)[0].position_m - recorded[0].position_m;
  EXPECT_EQ(moved.z(), 0.0) << "contact with the ground is kept";
  for (const TrackFrame& frame : clip.tracks.frames) {
    const double t = ToSeconds(frame.time);
    ASSERT_TRUE(people[0]->PresentAt(t));
    const Pose3d pose = people[0]->PoseAt(t);
    for (size_t j = 0; j < pose.size(); ++j) {
      EXPECT_LT(
          (pose[j].position_m - moved - frame.people[0].joints[j].position_m)
              .norm(),
          1e-12);
    }
  }
}

TEST(RecordedPeople, ArePresentForTheLengthOfTheClip) {
  RecordedPeopleOptions options = InPlace();
  options.start_s = {1.5};
  const MotionClip clip = Walk();
  const double length = ToSeconds(clip.tracks.frames.back().time);
  const People people = Make(options, {clip});
  EXPECT_FALSE(people[0]->PresentAt(1.49));
  EXPECT_TRUE(people[0]->PresentAt(1.5));
  EXPECT_TRUE(people[0]->PresentAt(1.5 + length));
  EXPECT_FALSE(people[0]->PresentAt(1.51 + length));
  EXPECT_NEAR(EndOf(people), 1.5 + length, 1e-9);
}

TEST(RecordedPeople, PlacementMovesAndRotatesThePath) {
  RecordedPeopleOptions options = InPlace();
  const MotionClip clip = Walk();
  const People plain = Make(options, {clip});
  options.x_m = {1.25};
  options.y_m = {-0.5};
  options.turn_deg = {90.0};
  const People turned = Make(options, {clip});
  for (const double t : {0.0, 1.0, 3.0}) {
    const Pose3d a = plain[0]->PoseAt(t);
    const Pose3d b = turned[0]->PoseAt(t);
    for (size_t j = 0; j < a.size(); ++j) {
      const Vector3d p = a[j].position_m;
      const Vector3d expected(-p.y() + 1.25, p.x() - 0.5, p.z());
      EXPECT_LT((b[j].position_m - expected).norm(), 1e-12);
    }
  }
}

TEST(RecordedPeople, DrawnPlacesLieInTheRoomAndKeepDistance) {
  ClipRoom room;
  room.radius_m = 5.0;
  room.min_distance_m = 0.6;
  const std::vector<MotionClip> clips = {Walk(), Walk(), Walk()};
  RecordedPeopleOptions options;
  options.clips = {"a", "b", "c"};
  for (const uint64_t seed : {1u, 2u, 3u, 4u}) {
    room.seed = seed;
    const People people = Make(options, clips, room);
    const People again = Make(options, clips, room);
    ASSERT_EQ(people.size(), 3u);
    for (double t = 0.0; t < 3.96; t += 0.1) {
      for (size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(people[i]->PoseAt(t)[4].position_m,
                  again[i]->PoseAt(t)[4].position_m);
        for (const Joint3d& joint : people[i]->PoseAt(t)) {
          EXPECT_LE(joint.position_m.head<2>().norm(), 5.0 + 0.01)
              << "between frames the spline may overshoot";
        }
        for (size_t k = 0; k < i; ++k) {
          EXPECT_GE(
              (people[i]->TrunkAt(t).origin_m - people[k]->TrunkAt(t).origin_m)
                  .head<2>()
                  .norm(),
              0.6 - 0.1)
              << "distances are checked ten times a second";
        }
      }
    }
    room.seed = seed + 100;
    EXPECT_NE(people[0]->PoseAt(0.0)[0].position_m,
              Make(options, clips, room)[0]->PoseAt(0.0)[0].position_m);
    // An additional clip does not move the others.
    room.seed = seed;
    const People fewer = Make(options, {clips[0], clips[1]}, room);
    EXPECT_EQ(people[1]->PoseAt(1.0)[0].position_m,
              fewer[1]->PoseAt(1.0)[0].position_m);
  }
}

TEST(RecordedPeople, PeopleOfOneFileKeepRelativePositions) {
  const MotionClip clip = Walk(3);
  RecordedPeopleOptions options;
  const People people = Make(options, {clip});
  ASSERT_EQ(people.size(), 3u);
  const TrackFrame& frame = clip.tracks.frames[50];
  const double t = ToSeconds(frame.time);
  for (size_t i = 1; i < 3; ++i) {
    EXPECT_NEAR(Apart(people[i]->PoseAt(t)[5], people[0]->PoseAt(t)[5]),
                Apart(frame.people[i].joints[5], frame.people[0].joints[5]),
                1e-9);
    EXPECT_EQ(people[i]->Facts().clip_id, frame.people[i].id);
  }
}

TEST(RecordedPeople, AHeldPoseSwaysAndThenMovesWithoutAJump) {
  RecordedPeopleOptions options = InPlace();
  options.hold_s = {20.0};
  const MotionClip clip = Walk();
  const People people = Make(options, {clip});
  options.hold_sway_m = 0.0;
  const People still = Make(options, {clip});
  const double length = ToSeconds(clip.tracks.frames.back().time);
  EXPECT_NEAR(EndOf(people), 20.0 + length + 0.5 * kStartRamp, 1e-9);

  const int shoulder = Coco17().IndexOf("l_shoulder");
  const int ankle = Coco17().IndexOf("l_ankle");
  const Pose3d first = still[0]->PoseAt(0.0);
  double square = 0.0;
  int count = 0;
  for (double t = 0.0; t < 19.0; t += 0.05, ++count) {
    const Pose3d pose = people[0]->PoseAt(t);
    EXPECT_LT(BoneChange(pose, first), 1e-12) << "the body sways as one piece";
    EXPECT_EQ(still[0]->PoseAt(t)[shoulder].position_m,
              first[shoulder].position_m);
    // Feet hardly move: at half a step from the middle of the ankles a rotation
    // of three times 6 mm/m displaces them by at most 1 cm.
    EXPECT_LT(Apart(pose[ankle], first[ankle]), 0.01);
    square +=
        (pose[shoulder].position_m - first[shoulder].position_m).squaredNorm();
  }
  // RMS of 6 mm forward and 3.6 mm to the side at 1 m; the shoulder is 1.3 m
  // above the ankles: 9.1 mm. Sums of five sines over a few periods of the
  // slowest sine vary by a third.
  const double rms = std::sqrt(square / count);
  EXPECT_GT(rms, 0.006);
  EXPECT_LT(rms, 0.012);

  // No jump: second differences over 10 ms stay within human limits. The walker
  // reaches 2 m/s within the ramp of 0.3 s.
  for (double t = 19.0; t < 20.6; t += 0.01) {
    const auto at = [&](double time) {
      return people[0]->PoseAt(time)[shoulder].position_m;
    };
    EXPECT_LT((at(t + 0.01) - 2.0 * at(t) + at(t - 0.01)).norm() / 1e-4, 25.0)
        << t;
  }
  // Afterwards the motion is that of the clip.
  const double t = 22.0;
  const People alone = Make(InPlace(), {clip});
  EXPECT_LT(Apart(people[0]->PoseAt(t)[3],
                  alone[0]->PoseAt(t - 20.0 - 0.5 * kStartRamp)[3]),
            1e-9);
}

TEST(RecordedPeople, JointCentresMoveWithTheAngleOfTheJoint) {
  RecordedPeopleOptions options = InPlace();
  const MotionClip clip = Walk();
  const People rigid = Make(options, {clip});
  options.joint_sway_m = 0.010;
  const People swaying = Make(options, {clip});
  std::vector<double> largest(17, 0.0);
  for (double t = 0.0; t < 3.96; t += 0.02) {
    for (size_t j = 0; j < 17; ++j) {
      largest[j] = std::max(
          largest[j], Apart(rigid[0]->PoseAt(t)[j], swaying[0]->PoseAt(t)[j]));
    }
  }
  for (size_t j = 0; j < 5; ++j) EXPECT_EQ(largest[j], 0.0) << "the face";
  for (size_t j = 5; j < largest.size(); ++j) {
    // Amplitudes are 0.5 to 1.5 times joint_sway_m, 5 to 15 mm; less is
    // reached where the joint hardly bends.
    EXPECT_GT(largest[j], 0.0005) << Coco17().joints()[j];
    EXPECT_LT(largest[j], 0.0155) << Coco17().joints()[j];
  }
  const int knee = Coco17().IndexOf("l_knee");
  EXPECT_GT(largest[static_cast<size_t>(knee)], 0.0045) << "walking bends it";
  EXPECT_GT(BoneChange(swaying[0]->PoseAt(0.5), swaying[0]->PoseAt(0.9)),
            0.001);
}

TEST(RecordedPeople, FacingAndOcclusionMatchTheSimulatedBody) {
  const Scene scene = Walkers(1);
  const People people = Make(InPlace(), {Walk()});
  for (const double t : {0.0, 0.7, 1.5}) {
    const SegmentPose seen = people[0]->TrunkAt(t);
    const SegmentPose simulated = scene.people[0]->TrunkAt(t);
    EXPECT_GT(seen.R.col(0).dot(simulated.R.col(0)), 0.98);
    EXPECT_GT(seen.R.col(1).dot(simulated.R.col(1)), 0.98);
    EXPECT_NEAR(seen.R.determinant(), 1.0, 1e-12);
    // Looking from one side through the middle of the trunk.
    const Vector3d middle = seen.origin_m + 0.2 * seen.R.col(2);
    const Obstacle body = people[0]->ObstacleAt(t);
    EXPECT_TRUE(
        body.Hides(middle + Vector3d(3, 0, 0), middle - Vector3d(3, 0, 0)));
    EXPECT_FALSE(
        body.Hides(middle + Vector3d(3, 1, 0), middle + Vector3d(-3, 1, 0)));
  }
  EXPECT_NEAR(people[0]->Facts().stature_m, scene.people[0]->Facts().stature_m,
              0.05);
}

TEST(RecordedPeople, ShortGapsAreBridgedAndLongGapsAreAbsences) {
  MotionClip clip = Walk();
  auto& frames = clip.tracks.frames;
  for (size_t f = 30; f < 36; ++f) frames[f].people.clear();  // 0.23 s
  for (size_t f = 60; f < 75; ++f) frames[f].people.clear();  // 0.53 s
  const People people = Make(InPlace(), {clip});
  EXPECT_TRUE(people[0]->PresentAt(1.1));
  EXPECT_FALSE(people[0]->PresentAt(2.2));
  EXPECT_TRUE(people[0]->PresentAt(2.6));
  EXPECT_EQ(people[0]->Facts().present.size(), 2u);
}

std::string ErrorOf(const RecordedPeopleOptions& options,
                    const MotionClip& clip) {
  try {
    Make(options, {clip});
  } catch (const InputError& error) {
    return error.what();
  } catch (const OptionError& error) {
    return error.key() + ": " + error.message();
  }
  return "";
}

TEST(RecordedPeople, AFrameWithoutAJointIsAGap) {
  const MotionClip whole = Walk();
  MotionClip clip = whole;
  const size_t middle = clip.tracks.frames.size() / 2;
  clip.tracks.frames[middle].people[0].joints[9] = Joint3d();
  const double t = ToSeconds(clip.tracks.frames[middle].time);
  const People people = Make(InPlace(), {clip});
  ASSERT_TRUE(people[0]->PresentAt(t));
  const Pose3d bridged = people[0]->PoseAt(t);
  const Pose3d expected = Make(InPlace(), {whole})[0]->PoseAt(t);
  // The missing joint is stored at the origin; interpolation over one missing
  // frame has a small error.
  for (size_t j = 0; j < expected.size(); ++j) {
    EXPECT_LT((bridged[j].position_m - expected[j].position_m).norm(), 0.02);
  }
  for (TrackFrame& frame : clip.tracks.frames) {
    if (std::abs(ToSeconds(frame.time) - t) > 0.3) continue;
    frame.people[0].joints[9] = Joint3d();
  }
  EXPECT_FALSE(Make(InPlace(), {clip})[0]->PresentAt(t));
}

TEST(RecordedPeople, ErrorsNameInvalidClips) {
  const auto expect = [](const std::string& text, auto spoil) {
    MotionClip clip = Walk();
    spoil(&clip.tracks);
    EXPECT_THAT(ErrorOf({}, clip), HasSubstr(text));
  };
  expect("walk.jsonl: no frames", [](auto* t) { t->frames.clear(); });
  expect("walk.jsonl: no people", [](auto* t) {
    for (TrackFrame& frame : t->frames) frame.people.clear();
  });
  expect("two frames", [](auto* t) { t->frames.resize(1); });
  expect("with every joint", [](auto* t) {
    for (TrackFrame& frame : t->frames) {
      frame.people[0].joints[9].status = JointStatus::kMissing;
    }
  });
  expect("walk.jsonl: frame 8: joint 'l_wrist' is not finite", [](auto* t) {
    t->frames[8].people[0].joints[9].position_m.x() = NAN;
  });
  expect("frame 1: its time is not later", [](auto* t) {
    for (TrackFrame& frame : t->frames) frame.time = 0;
  });
  expect("has no joint 'nose'", [](auto* t) { t->header.skeleton = Tum14(); });
  expect("clips: walk.jsonl: shoulders and hips coincide", [](auto* t) {
    for (TrackFrame& frame : t->frames) {
      for (Joint3d& joint : frame.people[0].joints) {
        joint.position_m = Vector3d(1, 2, 3);
      }
    }
  });
}

TEST(RecordedPeople, ErrorsNameOptionsThatDoNotFitTheClips) {
  const auto expect = [](const std::string& key, auto set) {
    RecordedPeopleOptions options;
    set(&options);
    EXPECT_THAT(ErrorOf(options, Walk()), StartsWith(key + ": "));
  };
  expect("start", [](auto* o) { o->start_s = {0.0, 1.0}; });
  expect("hold", [](auto* o) { o->hold_s = {0.0, 1.0}; });
  expect("hold", [](auto* o) { o->hold_s = {-1.0}; });
  expect("y", [](auto* o) { o->x_m = {1.0}; });
  expect("x", [](auto* o) { o->y_m = {1.0}; });
  expect("turn", [](auto* o) { o->turn_deg = {1.0, 2.0}; });
  expect("joint_sway", [](auto* o) { o->joint_sway_m = 1.0; });
  // Two clips of the same walk on a floor with space for one.
  ClipRoom room;
  room.radius_m = 0.1;
  room.min_distance_m = 5.0;
  EXPECT_THROW(Make(RecordedPeopleOptions(), {Walk(), Walk()}, room),
               OptionError);
}

TEST(RecordedPeople, RefusesAPersonNearACamera) {
  RecordedPeopleOptions options = InPlace();
  options.x_m = {6.5};
  SceneOptions scene;
  scene.cameras.height_m = 1.0;
  scene.duration_s = 3.0;
  EXPECT_THROW(MakeScene(scene, Coco17(), Make(options, {Walk()})),
               OptionError);
}

}  // namespace
}  // namespace kinegraph
