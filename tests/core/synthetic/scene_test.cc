#include "core/synthetic/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "core/base/error.h"

namespace kinegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

SceneOptions Options(int64_t seed, int64_t people) {
  SceneOptions options;
  options.seed = seed;
  options.people = people;
  options.duration_s = 30.0;
  options.motion.sitting = 0.3;
  return options;
}

// Visits all present people, frame by frame.
template <typename Visit>
void ForEachPose(const Scene& scene, const Visit& visit) {
  for (size_t k = 0; k < scene.poses.size(); ++k) {
    for (size_t i = 0; i < scene.people.size(); ++i) {
      if (!scene.poses[k][i].empty()) visit(k, i, scene.poses[k][i]);
    }
  }
}

// Largest deviation of any bone of any person from its length in the person's
// first frame [m].
double BoneSpread(const Scene& scene) {
  double worst = 0.0;
  std::map<size_t, std::vector<double>> lengths;
  ForEachPose(scene, [&](size_t, size_t person, const Pose3d& pose) {
    std::vector<double> now;
    for (const Bone& bone : scene.skeleton.bones()) {
      now.push_back((pose[bone.a].position_m - pose[bone.b].position_m).norm());
    }
    const auto& first = lengths.try_emplace(person, now).first->second;
    for (size_t b = 0; b < now.size(); ++b) {
      worst = std::max(worst, std::abs(now[b] - first[b]));
    }
  });
  return worst;
}

TEST(Scene, BoneLengthsAreConstant) {
  SceneOptions options = Options(3, 4);
  for (const char* skeleton : {"coco17", "body25", "body25b", "panoptic19"}) {
    options.skeleton = skeleton;
    EXPECT_LT(BoneSpread(MakeScene(options)), 1e-12) << skeleton;
  }
  // A flexible trunk changes only bones across spine and neck.
  options.trunk_flexibility = 1.0;
  options.skeleton = "body25";  // bones cross the spine only on its axis
  EXPECT_LT(BoneSpread(MakeScene(options)), 1e-12);
  options.skeleton = "coco17";  // shoulder to hip, ear to shoulder
  const double spread = BoneSpread(MakeScene(options));
  EXPECT_GT(spread, 1e-3);
  EXPECT_LT(spread, 0.15);
}

// Greatest speed and acceleration by joint, at 100 Hz.
TEST(Scene, MovesWithinHumanLimits) {
  // Walking and gestures. Trunk: the centre of mass of a walker has less than 2
  // m/s^2 on average and a few at its peaks; sitting down adds some. Feet: in a
  // brisk walk the swing foot reaches 4-6 m/s, and 5-8 g where it reverses.
  struct Limit {
    const char* joint;
    double speed_ms;
    double acceleration_ms2;
  };
  const Limit limits[] = {{"mid_hip", 2.5, 20.0}, {"neck", 2.5, 25.0},
                          {"nose", 3.0, 30.0},    {"l_elbow", 5.0, 50.0},
                          {"l_wrist", 8.0, 80.0}, {"r_knee", 6.0, 100.0},
                          {"r_ankle", 8.0, 120.0}};
  for (const int64_t seed : {1, 2, 3}) {
    SceneOptions options = Options(seed, 6);
    options.skeleton = "body25";
    options.frame_rate_hz = 100.0;
    options.trunk_flexibility = 1.0;
    const Scene scene = MakeScene(options);
    const double dt = 0.01;
    for (const Limit& limit : limits) {
      const int j = scene.skeleton.IndexOf(limit.joint);
      double speed = 0.0;
      double acceleration = 0.0;
      ForEachPose(scene, [&](size_t k, size_t i, const Pose3d& now) {
        if (k == 0 || k + 1 == scene.poses.size()) return;
        const Pose3d& before = scene.poses[k - 1][i];
        const Pose3d& after = scene.poses[k + 1][i];
        if (before.empty() || after.empty()) return;
        const Vector3d& a = before[j].position_m;
        const Vector3d& b = now[j].position_m;
        const Vector3d& c = after[j].position_m;
        speed = std::max(speed, (c - a).norm() / (2.0 * dt));
        acceleration =
            std::max(acceleration, (c - 2.0 * b + a).norm() / (dt * dt));
      });
      EXPECT_LT(speed, limit.speed_ms) << limit.joint << " seed " << seed;
      EXPECT_LT(acceleration, limit.acceleration_ms2)
          << limit.joint << " seed " << seed;
      EXPECT_GT(speed, 0.5) << limit.joint << " hardly moves";
    }
  }
}

TEST(Scene, StandingFeetStayOnTheGround) {
  SceneOptions options = Options(4, 4);
  options.skeleton = "body25";
  const Scene scene = MakeScene(options);
  ForEachPose(scene, [&](size_t, size_t, const Pose3d& pose) {
    const auto height_of = [&](const char* name) {
      return pose[scene.skeleton.IndexOf(name)].position_m.z();
    };
    const double left = height_of("l_ankle"), right = height_of("r_ankle");
    EXPECT_GT(std::min(left, right), 0.04) << "about 6 cm above the sole";
    // At least one foot is on the ground; at push-off its ankle is higher by up
    // to 0.68 of the foot's length (0.26 m) times sin 0.66 rad.
    EXPECT_LT(std::min(left, right), 0.22);
    for (const char* name : {"l_big_toe", "r_big_toe", "l_heel", "r_heel"}) {
      // Toes are rigid here and roll over the ball, up to two centimetres below
      // the floor.
      EXPECT_GT(height_of(name), -0.02);
    }
  });
}

TEST(Scene, PlantedFeetDoNotSlide) {
  const Scene scene = MakeScene(Options(6, 2));
  int checked = 0;
  for (const char* name : {"l_ankle", "r_ankle"}) {
    const int ankle = scene.skeleton.IndexOf(name);
    std::map<size_t, double> flat_m;  // least height of the ankle, by person
    ForEachPose(scene, [&](size_t, size_t i, const Pose3d& pose) {
      const double z = pose[ankle].position_m.z();
      flat_m[i] = std::min(flat_m.try_emplace(i, z).first->second, z);
    });
    ForEachPose(scene, [&](size_t k, size_t i, const Pose3d& pose) {
      if (k == 0 || scene.poses[k - 1][i].empty()) return;
      const Vector3d& now = pose[ankle].position_m;
      const Vector3d& before = scene.poses[k - 1][i][ankle].position_m;
      if (std::max(now.z(), before.z()) > flat_m[i] + 1e-12) return;
      EXPECT_LT((now - before).norm(), 1e-12);
      ++checked;
    });
  }
  EXPECT_GT(checked, 100);
}

TEST(Scene, PeoplePassAtADistance) {
  for (const int64_t seed : {1, 2, 3, 4}) {
    SceneOptions options = Options(seed, 8);
    options.skeleton = "body25";
    const Scene scene = MakeScene(options);
    const int hip = scene.skeleton.IndexOf("mid_hip");
    const int neck = scene.skeleton.IndexOf("neck");
    double closest = 1e9;
    int near = 0;
    ForEachPose(scene, [&](size_t frame, size_t i, const Pose3d& pose) {
      for (size_t k = 0; k < i; ++k) {
        const Pose3d& other = scene.poses[frame][k];
        if (other.empty()) continue;
        for (const int joint : {hip, neck}) {
          const Vector3d gap = pose[joint].position_m - other[joint].position_m;
          closest = std::min(closest, gap.head<2>().norm());
          near += gap.head<2>().norm() < 1.0 ? 1 : 0;
        }
      }
    });
    // Centres are at least 0.55 m apart; smoothing of the paths, sway of the
    // pelvis and leaning to sit down may reduce this by 0.25 m. Trunks are 0.15
    // m thick.
    EXPECT_GT(closest, 0.30) << "seed " << seed;
    EXPECT_GT(near, 20) << "people do meet, seed " << seed;
  }
}

TEST(Scene, PeopleWalkSitGestureComeAndGo) {
  SceneOptions options = Options(2, 12);
  options.motion.area_radius_m = 5.0;
  options.cameras.radius_m = 9.0;
  options.motion.visitors = 0.5;
  const Scene scene = MakeScene(options);
  const auto at = [&](const Pose3d& pose, const char* name) {
    return pose[scene.skeleton.IndexOf(name)].position_m;
  };
  size_t seats = 0;
  int changes = 0;
  for (const auto& person : scene.people) {
    const ActorFacts facts = person->Facts();
    seats += facts.seated.size();
    for (const TimeSpan& span : facts.present) {
      changes += span.begin_s > 0.0 ? 1 : 0;
      changes += span.end_s < options.duration_s ? 1 : 0;
      // People appear outside the circle in which they walk.
      if (span.begin_s > 0.0) {
        EXPECT_GT(at(person->PoseAt(span.begin_s), "l_hip").head<2>().norm(),
                  5.0);
      }
    }
  }
  EXPECT_GT(seats, 2u);
  EXPECT_GT(changes, 3);
  double lowest = 1e9;
  double distance = 0.0;
  std::set<size_t> raised;
  ForEachPose(scene, [&](size_t k, size_t i, const Pose3d& pose) {
    if (at(pose, "l_wrist").z() > at(pose, "l_shoulder").z()) raised.insert(i);
    if (k == 0 || scene.poses[k - 1][i].empty()) return;
    lowest = std::min(lowest, at(pose, "l_hip").z());
    distance += (at(pose, "l_hip") - at(scene.poses[k - 1][i], "l_hip")).norm();
  });
  EXPECT_GT(raised.size(), 3u) << "they gesture";
  EXPECT_LT(lowest, 0.62) << "somebody sits";
  EXPECT_GT(distance / 12.0, 8.0) << "metres that a person walks in 30 s";
}

TEST(Scene, SceneIsDeterminedByTheSeed) {
  const auto numbers = [](int64_t seed) {
    const Scene scene = MakeScene(Options(seed, 3));
    std::vector<double> all;
    ForEachPose(scene, [&](size_t k, size_t i, const Pose3d& pose) {
      all.insert(all.end(), {static_cast<double>(k), static_cast<double>(i)});
      for (const Joint3d& joint : pose) {
        all.insert(all.end(), joint.position_m.data(),
                   joint.position_m.data() + 3);
      }
    });
    return all;
  };
  EXPECT_EQ(numbers(9), numbers(9));
  EXPECT_NE(numbers(9), numbers(10));
}

TEST(Scene, FrameRateSamplesTheSameMotion) {
  SceneOptions options = Options(12, 3);
  const Scene slow = MakeScene(options);
  options.frame_rate_hz = 100.0;
  const Scene fast = MakeScene(options);
  ASSERT_EQ(fast.times.size(), 4 * slow.times.size());
  for (size_t k = 0; k < slow.times.size(); ++k) {
    ASSERT_EQ(slow.times[k], fast.times[4 * k]);
    for (size_t i = 0; i < slow.people.size(); ++i) {
      ASSERT_EQ(slow.poses[k][i].empty(), fast.poses[4 * k][i].empty());
      if (slow.poses[k][i].empty()) continue;
      EXPECT_EQ(slow.poses[k][i][3].position_m,
                fast.poses[4 * k][i][3].position_m);
    }
  }
}

TEST(Scene, EveryRingSeesMoreThanNineTenthsOfAllJoints) {
  for (const int64_t count : {2, 3, 5, 8, 32}) {
    SceneOptions options = Options(1, 5);
    options.cameras.count = count;
    options.cameras.distortion = {-0.1, 0.02, 0.001, -0.001, 0.0};
    const Scene scene = MakeScene(options);
    ASSERT_EQ(scene.cameras.size(), static_cast<size_t>(count));
    EXPECT_EQ(scene.cameras[1].name(), "cam1");
    int64_t inside = 0;
    int64_t all = 0;
    ForEachPose(scene, [&](size_t, size_t, const Pose3d& pose) {
      for (const Joint3d& joint : pose) {
        for (const Camera& camera : scene.cameras) {
          const auto px = camera.Project(joint.position_m);
          ++all;
          inside += px.has_value() && IsInImage(camera, *px);
        }
      }
    });
    EXPECT_GT(static_cast<double>(inside), 0.9 * static_cast<double>(all))
        << count << " cameras";
  }
}

TEST(Scene, CamerasStandUprightOnTheRing) {
  RingOptions options;
  options.count = 6;
  const CameraRig rig = MakeRing(options);
  for (const Camera& camera : rig) {
    EXPECT_NEAR(camera.centre().head<2>().norm(), options.radius_m, 1e-12);
    EXPECT_NEAR(camera.centre().z(), options.height_m, 1e-12);
    // The target point is at the image's centre; higher points are above.
    const auto centre = camera.Project({0.0, 0.0, options.target_height_m});
    ASSERT_TRUE(centre.has_value());
    EXPECT_LT((*centre - Vector2d(640.0, 360.0)).norm(), 1e-9);
    EXPECT_LT(camera.Project({0.0, 0.0, 1.8})->y(), 360.0);
  }
  // Two cameras do not face each other: their axes enclose 60 to 120 degrees.
  options.count = 2;
  const CameraRig pair = MakeRing(options);
  const Vector3d a = pair[0].RayDirection({640.0, 360.0});
  const Vector3d b = pair[1].RayDirection({640.0, 360.0});
  EXPECT_LT(std::abs(a.dot(b)), 0.5);
}

TEST(Scene, TruthHasThePresentPeopleOfEachFrame) {
  const Scene scene = MakeScene(Options(2, 4));
  const TrackSequence truth = TruthOf(scene);
  ASSERT_EQ(truth.frames.size(), scene.times.size());
  EXPECT_EQ(truth.header.skeleton, scene.skeleton);
  EXPECT_EQ(truth.header.frame_rate_hz, 25.0);
  for (size_t k = 0; k < truth.frames.size(); ++k) {
    EXPECT_EQ(truth.frames[k].frame, static_cast<int64_t>(k));
    EXPECT_EQ(truth.frames[k].time, scene.times[k]);
    size_t present = 0;
    for (const Pose3d& pose : scene.poses[k]) present += pose.empty() ? 0 : 1;
    ASSERT_EQ(truth.frames[k].people.size(), present);
    for (const PersonPose& person : truth.frames[k].people) {
      const Pose3d& pose = scene.poses[k][person.id.value()];
      ASSERT_EQ(CountPresent(person.joints), scene.skeleton.joint_count());
      EXPECT_EQ(person.joints[0].position_m, pose[0].position_m);
    }
  }
}

TEST(Scene, ErrorsNameInvalidOptions) {
  const auto expect = [](const char* key, auto set) {
    SceneOptions options;
    set(&options);
    try {
      MakeScene(options);
      ADD_FAILURE() << key;
    } catch (const OptionError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(key));
    }
  };
  expect("people: found 0", [](auto* o) { o->people = 0; });
  expect("octopus", [](auto* o) { o->skeleton = "octopus"; });
  expect("cameras.count", [](auto* o) { o->cameras.count = 33; });
  expect("cameras.radius", [](auto* o) { o->cameras.radius_m = 3.5; });
  expect("distortion", [](auto* o) { o->cameras.distortion = {.1, .1, .1}; });
}

}  // namespace
}  // namespace kinegraph
