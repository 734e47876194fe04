#include "core/tracking/frame_observations.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "core/io/detections/source.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "tests/support/rig.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

// Joints along a line of `size_px` that starts at (at_px, 0).
Observation Person(double at_px, double size_px, double confidence,
                   int joints = 11) {
  Observation person;
  for (int j = 0; j < joints; ++j) {
    const double along = size_px * j / 10.0;
    Keypoint joint;
    joint.px = {at_px + 0.6 * along, 0.8 * along};
    joint.confidence = confidence;
    joint.found = true;
    person.joints.push_back(joint);
  }
  person.found_count = joints;
  person.mean_confidence = confidence;
  return person;
}

bool IsOnePerson(const Observation& a, const Observation& b) {
  std::vector<Observation> both = {a, b};
  return SuppressDuplicates(2, &both) == 1;
}

TEST(DuplicateSuppression, DistanceLimitIsATwentiethOfTheBoxDiagonal) {
  const Observation person = Person(100.0, 200.0, 0.8);
  EXPECT_TRUE(IsOnePerson(person, person));
  EXPECT_TRUE(IsOnePerson(person, Person(109.9, 200.0, 0.8)));
  EXPECT_FALSE(IsOnePerson(person, Person(110.1, 200.0, 0.8)));
  // The limit scales with the person: for a distant person with a diagonal of
  // 60 px it is 3 px, so 5 px mean two people.
  EXPECT_FALSE(IsOnePerson(Person(100.0, 60.0, 0.8), Person(105.0, 60.0, 0.8)));
}

TEST(DuplicateSuppression, HalfOfTheJointsMustBeCommon) {
  const Observation whole = Person(100.0, 200.0, 0.8);
  Observation part = whole;
  for (size_t j = 0; j < 8; ++j) part.joints[j].found = false;
  EXPECT_TRUE(IsOnePerson(whole, part));  // three of its three joints
  Observation rest = whole;
  for (size_t j = 9; j < 11; ++j) rest.joints[j].found = false;
  EXPECT_FALSE(IsOnePerson(part, rest));  // one of three
  for (Keypoint& joint : part.joints) joint.found = false;
  EXPECT_FALSE(IsOnePerson(part, whole));
  EXPECT_FALSE(IsOnePerson(part, part));
}

TEST(DuplicateSuppression, KeepsMoreJointsThenHigherConfidence) {
  std::vector<Observation> seen = {
      Person(100.0, 200.0, 0.5), Person(400.0, 200.0, 0.5),
      Person(101.0, 200.0, 0.9), Person(402.0, 200.0, 0.9)};
  seen[3].joints.back().found = false;
  seen[3].found_count = 10;
  seen.push_back(seen[1]);  // beyond `count`
  ASSERT_EQ(SuppressDuplicates(4, &seen), 2u);
  EXPECT_EQ(seen.size(), 5u);
  EXPECT_EQ(seen[0].joints[0].px.x(), 101.0);
  EXPECT_EQ(seen[1].joints[0].px.x(), 400.0);
}

struct Counts {
  size_t people = 0;  // with at least five of 17 joints
  size_t dropped = 0;
};

Counts CountsOf(const CameraRig& cameras, const DetectionSequence& recording) {
  const Skeleton& skeleton = recording.header.skeleton;
  FrameObservations all(cameras, skeleton, skeleton, 5.0,
                        /*suppress_duplicates=*/false);
  FrameObservations once(cameras, skeleton, skeleton, 5.0,
                         /*suppress_duplicates=*/true);
  Counts counts;
  for (const DetectionFrame& frame : recording.frames) {
    all.Prepare(frame);
    once.Prepare(frame);
    for (size_t v = 0; v < cameras.size(); ++v) {
      counts.people += all.OfView(v).size();
      counts.dropped += all.OfView(v).size() - once.OfView(v).size();
    }
  }
  return counts;
}

// These recordings contain no duplicates, so nobody may be dropped.
TEST(DuplicateSuppression, DropsNobodyOnShelfAndPose2Sim) {
  for (const auto& [name, least_people] :
       {std::pair{"shelf/detections/openpose", 4000u},
        {"pose2sim/single/pose", 300u},
        {"pose2sim/multi/pose", 300u}}) {
    KINEGRAPH_DATA_OR_SKIP(data, name);
    const DetectionSequence recording = ReadDetections(data);
    // The rule uses pixels only; any camera without lens distortion suffices.
    const CameraRig cameras(recording.header.view_names.size(),
                            testing::RingOfCameras(1).front());
    const Counts counts = CountsOf(cameras, recording);
    EXPECT_GT(counts.people, least_people) << name;
    EXPECT_EQ(counts.dropped, 0u) << name;
  }
}

// Eight people crowd a small area in view of five cameras, with a noisy
// detector that makes no duplicates: everything dropped was another person.
// Such drops happen in single frames when people pass in front of each other;
// more than one in a thousand would lose tracks.
TEST(DuplicateSuppression, RarelyDropsAnotherPerson) {
  SceneOptions scene_options;
  scene_options.seed = 951;
  scene_options.people = 8;
  scene_options.motion.area_radius_m = 2.5;
  const Scene scene = MakeScene(scene_options);
  NoiseOptions noise;
  noise.seed = 951;
  noise.joints.sigma_px = 5.0;
  noise.joints.missing_rate = 0.15;
  noise.joints.outlier_rate = 0.05;
  const Counts counts = CountsOf(scene.cameras, Observe(scene, noise, nullptr));
  EXPECT_GT(counts.people, 10000u);
  EXPECT_LT(1000 * counts.dropped, counts.people);
  RecordProperty("people", std::to_string(counts.people));
  RecordProperty("dropped", std::to_string(counts.dropped));
}

}  // namespace
}  // namespace kinegraph
