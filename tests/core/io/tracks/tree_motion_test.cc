// Bodies as trees of bones: BVH and glTF reproduce every joint.
#include "core/io/tracks/tree_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/median.h"
#include "core/io/files/text_file.h"
#include "core/io/text/joint_names.h"
#include "core/io/text/json.h"
#include "core/io/tracks/tracks.h"
#include "tests/core/io/input_error.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/base64.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using ::testing::Not;
using testing::RigidTruth;
using testing::TemporaryFolder;
using testing::TreeOf;
using testing::WriteAs;

// The largest distance [m] between the joints of the tracks and of the file, as
// read by BVH's reader, which has its own forward kinematics.
double WorstInBvh(const std::string& path, const TrackSequence& tracks) {
  const TrackSequence read = ReadTracks(path);
  const Skeleton ours = WithOurNames(tracks.header.skeleton);
  double worst_m = 0.0;
  for (size_t f = 0; f < tracks.frames.size(); ++f) {
    const Pose3d& pose = tracks.frames[f].people[0].joints;
    for (size_t j = 0; j < pose.size(); ++j) {
      const std::string& name = ours.joints()[j];
      const int at = read.header.skeleton.IndexOf(name);
      EXPECT_GE(at, 0) << name;
      if (at < 0 || !pose[j].present()) continue;
      const Joint3d& found =
          read.frames[f].people[0].joints[static_cast<size_t>(at)];
      worst_m =
          std::max(worst_m, (found.position_m - pose[j].position_m).norm());
    }
  }
  return worst_m;
}

// Reads a .gltf: numbers of an accessor, and joints of the first skin by name.
class GltfFile {
 public:
  explicit GltfFile(const std::string& path)
      : json_(Json::parse(ReadTextFile(path))) {
    const std::string uri = json_["buffers"][0]["uri"];
    bytes_ = testing::FromBase64(uri.substr(uri.find(',') + 1));
  }

  std::vector<float> Numbers(const Json& accessor_idx) const {
    const Json& accessor = json_["accessors"][accessor_idx.get<size_t>()];
    const Json& view =
        json_["bufferViews"][accessor["bufferView"].get<size_t>()];
    std::vector<float> numbers(view["byteLength"].get<size_t>() /
                               sizeof(float));
    std::memcpy(numbers.data(),
                bytes_.data() + view["byteOffset"].get<size_t>(),
                numbers.size() * sizeof(float));
    return numbers;
  }

  // Joint positions in a row that follow from rotations alone, the rest pose of
  // the skin and the root's position.
  std::map<std::string, Vector3d> ByRotations(size_t row) const {
    const Json& skin = json_["skins"][0];
    const std::vector<float> inverses = Numbers(skin["inverseBindMatrices"]);
    std::map<size_t, size_t> parent_of;
    for (size_t n = 0; n < json_["nodes"].size(); ++n) {
      const Json& node = json_["nodes"][n];
      if (!node.contains("children")) continue;
      for (const Json& child : node["children"]) {
        parent_of[child.get<size_t>()] = n;
      }
    }
    std::map<size_t, Vector3d> rest_m;
    std::map<size_t, Quaterniond> rotations;
    std::map<size_t, Vector3d> positions_m;
    std::map<std::string, Vector3d> result;
    for (size_t j = 0; j < skin["joints"].size(); ++j) {
      const auto node = skin["joints"][j].get<size_t>();
      const float* m = &inverses[16 * j];
      rest_m[node] = -Vector3d(m[12], m[13], m[14]);
      const Quaterniond local = RotationOf(node, row);
      const size_t parent = parent_of[node];
      if (rotations.count(parent) == 0) {
        rotations[node] = local;
        positions_m[node] = TranslationOf(node, row);
      } else {
        rotations[node] = rotations[parent] * local;
        positions_m[node] = positions_m[parent] +
                            rotations[parent] * (rest_m[node] - rest_m[parent]);
      }
      result[json_["nodes"][node]["name"]] = positions_m[node];
    }
    return result;
  }

  const Json& json() const { return json_; }

 private:
  std::vector<float> Channel(size_t node, const std::string& path) const {
    const Json& animation = json_["animations"][0];
    for (const Json& channel : animation["channels"]) {
      if (channel["target"]["node"] != node ||
          channel["target"]["path"] != path) {
        continue;
      }
      return Numbers(
          animation["samplers"][channel["sampler"].get<size_t>()]["output"]);
    }
    ADD_FAILURE() << "no " << path << " of node " << node;
    return {};
  }
  Quaterniond RotationOf(size_t node, size_t row) const {
    const std::vector<float> q = Channel(node, "rotation");
    return {q[4 * row + 3], q[4 * row], q[4 * row + 1], q[4 * row + 2]};
  }
  Vector3d TranslationOf(size_t node, size_t row) const {
    const std::vector<float> p = Channel(node, "translation");
    return {p[3 * row], p[3 * row + 1], p[3 * row + 2]};
  }

  Json json_;
  std::string bytes_;
};

// Bones from a list of pairs of joints.
std::vector<Bone> Bones(const std::vector<int>& ends) {
  std::vector<Bone> bones;
  for (size_t i = 0; i < ends.size(); i += 2) {
    bones.push_back({ends[i], ends[i + 1]});
  }
  return bones;
}

// A mouse as in SLEAP's projects, and a fly with six bones from the thorax.
const std::vector<Skeleton>& Animals() {
  static const std::vector<Skeleton> kAnimals = {
      Skeleton("mouse",
               {"snout", "ear_l", "ear_r", "neck", "hips", "tail_base",
                "tail_tip", "paw_l", "paw_r"},
               Bones({0, 3, 1, 3, 2, 3, 3, 4, 4, 5, 5, 6, 4, 7, 4, 8})),
      Skeleton("fly",
               {"head", "thorax", "abdomen", "wing_l", "wing_r", "leg_1",
                "leg_2", "tip_1", "tip_2", "eye_l", "eye_r"},
               Bones({1, 0, 1, 2, 1, 3, 1, 4, 1, 5,
                      1, 6, 5, 7, 6, 8, 0, 9, 0, 10}))};
  return kAnimals;
}

std::vector<Skeleton> AllSkeletons() {
  std::vector<Skeleton> all = Animals();
  for (const std::string& name : SkeletonNames()) {
    all.push_back(*FindSkeleton(name));
  }
  return all;
}

class TreeMotionTest : public ::testing::Test {
 protected:
  const TemporaryFolder folder_;
  const std::string bvh_ = folder_.path() / "person_0.bvh";
  const std::string gltf_ = folder_.path() / "take.gltf";
};

// Rounding of centimetres and degrees to six decimals, along at most ten bones
// of 0.25 m.
constexpr double kBvhDigits_m = 1e-6;

// Also for a single frame, which defines the shape, and for mirror images,
// which are rigid too.
TEST_F(TreeMotionTest, BvhReproducesEveryJointOfARigidBody) {
  for (const Skeleton& skeleton : AllSkeletons()) {
    for (const auto& [frames, side] : {std::pair(40, 1), {1, 1}, {30, -1}}) {
      SCOPED_TRACE(skeleton.name() + " " + std::to_string(frames));
      TrackSequence truth = RigidTruth(skeleton, frames);
      for (TrackFrame& frame : truth.frames) {
        for (Joint3d& joint : frame.people[0].joints) {
          joint.position_m.x() *= side;
        }
      }
      EXPECT_THAT(WriteAs("bvh", bvh_, truth),
                  Contains(HasSubstr("lie 0.0 mm (RMS) and at most 0.0 mm")));
      EXPECT_LT(WorstInBvh(bvh_, truth), kBvhDigits_m);
    }
  }
}

// Along ten links of at most 0.25 m, with rotations of four floats accurate to
// 2^-23 and the root at 1 m accurate to 2^-24, the error is about
//   10 * 10 / 2 * 0.25 m * 2^-23 + 2^-24 m = 1.6e-6 m;
// the tolerance is more than ten times that.
constexpr double kGltfDigits_m = 2e-5;

// The position of a joint in the axes of glTF.
Vector3d InGltf(const TrackSequence& tracks, size_t frame,
                const std::string& joint) {
  const int index = tracks.header.skeleton.IndexOf(joint);
  const Vector3d& at = tracks.frames[frame]
                           .people[0]
                           .joints.at(static_cast<size_t>(index))
                           .position_m;
  return {at.x(), at.z(), -at.y()};
}

TEST_F(TreeMotionTest, GltfRotationsReproduceEveryJointOfARigidBody) {
  for (const Skeleton& skeleton : AllSkeletons()) {
    const TrackSequence truth = RigidTruth(skeleton, 40);
    WriteAs("gltf", gltf_, truth);
    const GltfFile file(gltf_);
    double worst_m = 0.0;
    for (const size_t f : {0u, 17u, 39u}) {
      const std::map<std::string, Vector3d> found = file.ByRotations(f);
      for (const std::string& joint : skeleton.joints()) {
        worst_m = std::max(worst_m,
                           (found.at(joint) - InGltf(truth, f, joint)).norm());
      }
    }
    EXPECT_LT(worst_m, kGltfDigits_m) << skeleton.name();
  }
}

// Tracks without these joints in the frames from `begin` to `end` - 1.
TrackSequence WithoutJoints(const Skeleton& skeleton,
                            const std::vector<std::string>& joints,
                            int64_t frames = 20, int64_t begin = 0,
                            int64_t end = 20) {
  TrackSequence tracks = RigidTruth(skeleton, frames);
  for (TrackFrame& frame : tracks.frames) {
    if (frame.frame < begin || frame.frame >= end) continue;
    for (const std::string& joint : joints) {
      frame.people[0].joints[static_cast<size_t>(skeleton.IndexOf(joint))] = {};
    }
  }
  return tracks;
}

// Missing in ten frames are the hips, whose mean is the root, and all but one
// joint of a hand.
TEST_F(TreeMotionTest, MissingJointsDoNotAffectObservedBones) {
  const TrackSequence truth = WithoutJoints(
      MediaPipe33(), {"l_hip", "r_hip", "l_pinky", "l_thumb"}, 40, 10, 20);
  // Ten frames of four joints; the middle of the hips is not a joint of the
  // skeleton.
  EXPECT_THAT(WriteAs("bvh", bvh_, truth),
              Contains(HasSubstr("40 missing joints")));
  const TrackSequence read = ReadTracks(bvh_);
  // Bones keep their directions for any motion of the root.
  const auto finger = [](const TrackSequence& tracks, size_t frame) {
    const auto at = [&](const char* joint) {
      const int index = tracks.header.skeleton.IndexOf(joint);
      return tracks.frames[frame]
          .people[0]
          .joints.at(static_cast<size_t>(index))
          .position_m;
    };
    return Vector3d(at("l_index") - at("l_wrist")).normalized();
  };
  for (size_t f = 0; f < 40; ++f) {
    // A single bone does not determine the rotation of the hand. The rotation
    // interpolated over time, added with a weight of 1e-6 (kWeak in
    // tree_motion.cc), slightly changes the direction of the bone.
    EXPECT_LT((finger(read, f) - finger(truth, f)).norm(), 2e-6) << f;
  }
}

// Length [cm] of the bone to each joint in the rest pose, from the text.
// Pivots, which have no length, are omitted.
std::map<std::string, double> OffsetLengths(const std::string& bvh) {
  std::map<std::string, double> lengths;
  std::istringstream words(bvh);
  std::string name;
  for (std::string word; words >> word && word != "MOTION";) {
    if (word == "JOINT") words >> name;
    if (word == "End") name.clear();
    if (word != "OFFSET" || name.empty()) continue;
    Vector3d offset;
    words >> offset.x() >> offset.y() >> offset.z();
    if (name.find("_to_") == std::string::npos) lengths[name] = offset.norm();
  }
  return lengths;
}

TEST_F(TreeMotionTest, LengthsOfUnseenLegsFollowFromStature) {
  const std::vector<std::string> legs = {
      "l_knee", "r_knee",    "l_ankle",     "r_ankle", "l_big_toe",
      "l_heel", "r_big_toe", "l_small_toe", "r_heel",  "r_small_toe"};
  const TrackSequence tracks = WithoutJoints(Halpe26(), legs);
  const LostFields lost_fields = WriteAs("bvh", bvh_, tracks);
  EXPECT_THAT(lost_fields,
              Contains(HasSubstr("never seen: l_knee, l_ankle, r_knee, ")));
  EXPECT_THAT(lost_fields, Contains(HasSubstr("Drillis and Contini")));
  EXPECT_THAT(lost_fields,
              Not(Contains(HasSubstr("missing joints were interpolated"))));
  const auto lengths = OffsetLengths(ReadTextFile(bvh_));
  for (const auto& [joint, length_cm] : lengths) {
    EXPECT_GT(length_cm, 0.1) << joint;
  }
  // A thigh is 0.245 of the stature, a shank 0.246; offsets have six decimals
  // [cm].
  EXPECT_NEAR(lengths.at("l_ankle") / lengths.at("l_knee"), 0.246 / 0.245,
              1e-6);
  EXPECT_EQ(lengths.at("l_knee"), lengths.at("r_knee"));
}

TEST_F(TreeMotionTest, UnseenLegHasTheLengthsOfTheOtherLeg) {
  WriteAs("bvh", bvh_,
          WithoutJoints(Halpe26(), {"l_knee", "l_ankle", "l_heel", "l_big_toe",
                                    "l_small_toe"}));
  const auto lengths = OffsetLengths(ReadTextFile(bvh_));
  // Offsets have six decimals [cm].
  EXPECT_NEAR(lengths.at("l_knee"), lengths.at("r_knee"), 1e-5);
}

// A person at a desk. Hips and legs are still written, with lengths.
TEST_F(TreeMotionTest, WithUnseenHipsTheNeckIsTheRoot) {
  const std::vector<std::string> below = {"l_hip",  "r_hip",   "l_knee",
                                          "r_knee", "l_ankle", "r_ankle"};
  const TrackSequence tracks = WithoutJoints(Coco17(), below);
  EXPECT_THAT(WriteAs("bvh", bvh_, tracks),
              Contains(HasSubstr("never seen: l_hip, r_hip, l_knee, r_knee, "
                                 "l_ankle, r_ankle;")));
  EXPECT_LT(WorstInBvh(bvh_, tracks), kBvhDigits_m);
  EXPECT_THAT(ReadTextFile(bvh_), HasSubstr("ROOT neck"));
  for (const auto& [joint, length_cm] : OffsetLengths(ReadTextFile(bvh_))) {
    EXPECT_GT(length_cm, 0.1) << joint;
  }
}

TEST_F(TreeMotionTest, UnseenJointBetweenSeenJointsIsNotedAndWritten) {
  const TrackSequence tracks = WithoutJoints(Coco17(), {"l_elbow"});
  EXPECT_THAT(WriteAs("gltf", gltf_, tracks),
              Contains(HasSubstr("never seen: l_elbow;")));
  const GltfFile file(gltf_);
  const auto arm_m = [&](size_t frame) {
    return Vector3d(InGltf(tracks, frame, "l_wrist") -
                    InGltf(tracks, frame, "l_shoulder"));
  };
  // Upper arm and forearm have half the arm's median length and point to the
  // wrist.
  std::vector<double> halves_m;
  for (size_t f = 0; f < tracks.frames.size(); ++f) {
    halves_m.push_back(0.5 * arm_m(f).norm());
  }
  const double half_m = Median(halves_m);
  for (const size_t f : {3u, 11u}) {
    const auto found = file.ByRotations(f);
    const Vector3d from_m = InGltf(tracks, f, "l_shoulder");
    const Vector3d bone_m = half_m * arm_m(f).normalized();
    EXPECT_LT((found.at("l_elbow") - from_m - bone_m).norm(), kGltfDigits_m);
    EXPECT_LT((found.at("l_wrist") - from_m - 2.0 * bone_m).norm(),
              kGltfDigits_m);
  }
}

TEST_F(TreeMotionTest, PointsWithoutBonesAreWrittenToGltfButNotBvh) {
  const Skeleton points("markers", {"C7", "STRN", "CLAV"}, {});
  TrackSequence tracks = RigidTruth(points, 5);
  EXPECT_THAT(
      InputErrorOf([&] { WriteAs("bvh", bvh_, tracks); }),
      HasSubstr("the skeleton 'markers' has none; C3D, TRC and glTF can"));
  EXPECT_THAT(
      WriteAs("gltf", gltf_, tracks),
      Contains("no bone connects STRN, CLAV: written as points below C7"));
  EXPECT_EQ(GltfFile(gltf_).ByRotations(0).size(), 3u);
}

TEST_F(TreeMotionTest, TreeFollowsTheBonesOfTheFile) {
  // In Human 3.6M's skeleton the neck is a child of the thorax, which joint
  // names do not reveal.
  const Skeleton h36m(
      "custom",
      {"mid_hip", "r_hip", "r_knee", "r_ankle", "l_hip", "l_knee", "l_ankle",
       "spine", "thorax", "neck", "head_top", "l_shoulder", "l_elbow",
       "l_wrist", "r_shoulder", "r_elbow", "r_wrist"},
      Bones({0, 1, 1, 2,  2, 3,  0,  4,  4,  5,  5, 6,  0,  7,  7,  8,
             8, 9, 9, 10, 8, 11, 11, 12, 12, 13, 8, 14, 14, 15, 15, 16}));
  const JointTree tree = TreeOf(h36m);
  EXPECT_EQ(tree[0].name, "mid_hip");
  for (const TreeJoint& joint : tree) {
    if (joint.name == "neck" || joint.name == "l_shoulder") {
      EXPECT_EQ(tree[joint.parent].name, "thorax") << joint.name;
    }
    EXPECT_EQ(joint.is_chest, joint.name == "thorax");
    EXPECT_TRUE(joint.is_held);
  }
  // An animal gets no directions from human anatomy.
  for (const TreeJoint& joint : TreeOf(Animals()[0])) {
    EXPECT_TRUE(joint.rest_direction.isZero()) << joint.name;
  }
}

// Poses of people who are present only briefly are not repeated in all frames.
TEST_F(TreeMotionTest, BvhOfManyPeoplePresentBrieflyHasOnlyTheirRows) {
  const TrackSequence one = RigidTruth(Coco17(), 3);
  TrackSequence tracks;
  tracks.header = one.header;
  constexpr int64_t kPeople = 450;  // 450 * 450 exceeds 200,000 rows
  for (int64_t f = 0; f < kPeople; ++f) {
    TrackFrame& frame = tracks.frames.emplace_back();
    frame.frame = f;
    frame.people = one.frames[0].people;
    frame.people[0].id = TrackId(f);
  }
  EXPECT_THAT(WriteAs("bvh", folder_.path() / "bvh", tracks),
              Contains(HasSubstr("each file begins and ends with its person")));
  EXPECT_THAT(ReadTextFile(folder_.path() / "bvh" / "person_7.bvh"),
              HasSubstr("Frames: 1\n"));
  tracks.frames.resize(400);  // 400 * 400 rows
  EXPECT_THAT(WriteAs("bvh", folder_.path() / "few", tracks),
              Not(Contains(HasSubstr("begins and ends"))));
  EXPECT_THAT(ReadTextFile(folder_.path() / "few" / "person_7.bvh"),
              HasSubstr("Frames: 400\n"));
}

TEST_F(TreeMotionTest, GltfRefusesValuesBeyondFloatRange) {
  TrackSequence tracks = RigidTruth(Coco17(), 2);
  tracks.frames[1].people[0].joints[3].position_m.x() = 1e300;
  EXPECT_THAT(InputErrorOf([&] { WriteAs("gltf", gltf_, tracks); }),
              HasSubstr("32-bit float"));
}

// ---- BVH of other programs ----

constexpr const char* kBvh =
    "HIERARCHY\r\n"
    "ROOT mixamorig:Hips\n{\n  OFFSET 1 2 3\n"
    "  CHANNELS 6 Xposition Yposition Zposition Yrotation Xrotation Zrotation\n"
    "  JOINT LeftUpLeg\n  {\n    OFFSET 10 0 0\n"
    "    CHANNELS 3 Zrotation Yrotation Xrotation\n"
    "    JOINT LeftLeg\n    {\n      OFFSET 0 -40 0\n"
    "      CHANNELS 3 Zrotation Yrotation Xrotation\n"
    "      End Site\n      {\n        OFFSET 0 -40 0\n      }\n    }\n  }\n"
    "  JOINT twist\n  {\n    OFFSET 0 0 0\n    CHANNELS 1 Yrotation\n"
    "    JOINT Neck\n    {\n      OFFSET 0 50 0\n      CHANNELS 0\n"
    "      End Site { OFFSET 0 1 0 }\n    }\n  }\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.0333333\n";

TEST(TracksBvh, ReadsChannelsAndNamesOfOtherPrograms) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("dance.bvh", std::string(kBvh) +
                                    "0 100 0  90 0 0  0 0 0  0 0 0  0\n"
                                    "0 100 0  0 0 0  90 0 0  0 0 0  45\n");
  TrackReadOptions options;
  options.axes = AxisMap::Parse("x,y,z");
  const TrackSequence tracks = ReadTracks(path, options);
  EXPECT_EQ(tracks.header.frame_rate_hz, 30.0);
  EXPECT_EQ(tracks.header.skeleton.joints(),
            (std::vector<std::string>{"mid_hip", "l_hip", "l_knee", "neck"}));
  ASSERT_EQ(tracks.header.skeleton.bones().size(), 3u);
  EXPECT_EQ(tracks.header.skeleton.bones()[2].a, 0) << "past the pivot";
  ASSERT_EQ(tracks.frames.size(), 2u);
  const auto at = [&](size_t frame, size_t joint) {
    return tracks.frames[frame].people.at(0).joints.at(joint).position_m;
  };
  // The position replaces the offset.
  EXPECT_LT((at(0, 0) - Vector3d(0.0, 1.0, 0.0)).norm(), 1e-12);
  // Rotated about Y by 90 degrees, X points to -Z.
  EXPECT_LT((at(0, 1) - Vector3d(0.0, 1.0, -0.1)).norm(), 1e-12);
  EXPECT_LT((at(0, 2) - Vector3d(0.0, 0.6, -0.1)).norm(), 1e-12);
  // The thigh is rotated about Z by 90 degrees: -Y becomes X.
  EXPECT_LT((at(1, 2) - Vector3d(0.5, 1.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((at(1, 3) - Vector3d(0.0, 1.5, 0.0)).norm(), 1e-12);
}

TEST(TracksBvh, ErrorsNameFileAndLine) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& content) {
    const std::string path = folder.Write("dance.bvh", content);
    return InputErrorOf([&] { ReadTracks(path); });
  };
  EXPECT_THAT(error(std::string(kBvh) + "0 1 2 3"),
              HasSubstr("dance.bvh: line 35: ends before a channel's value"));
  EXPECT_THAT(error("HIERARCHY\nROOT Hips\n{\nCHANNELS 2 Xposition Xscale"),
              HasSubstr("found 'Xscale', expected Xposition .. Zrotation"));
  EXPECT_THAT(error("HIERARCHY\nROOT Hips\n{\nOFFSET 0 nan 0"),
              HasSubstr("line 4: found 'nan'"));
  EXPECT_THAT(error("HIERARCHY\nROOT Hips\n{\n}\nMOTION\nFrames: 1e9\n"
                    "Frame Time: 0.01\n"),
              HasSubstr("Frames: expected 0 .. 10000000"));
}

// A frame time that is the rounded period of a whole rate means this rate,
// unless it has too few digits; NTSC rates are lower by a thousandth.
TEST(TracksBvh, RatesFollowFromRoundedFrameTimes) {
  const TemporaryFolder folder;
  const auto rate_of = [&](const std::string& step_s) {
    return ReadTracks(folder.Write("a.bvh",
                                   "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\n"
                                   "CHANNELS 3 Xposition Yposition Zposition\n"
                                   "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\n"
                                   "Frames: 1\nFrame Time: " +
                                       step_s + "\n0 0 0\n"))
        .header.frame_rate_hz;
  };
  EXPECT_EQ(rate_of("0.0333333"), 30.0);
  EXPECT_EQ(rate_of("0.033333"), 30.0);
  EXPECT_EQ(rate_of("0.00833"), 120.0);
  EXPECT_EQ(rate_of("0.0333"), 30.0);
  EXPECT_EQ(rate_of("0.0083"), 120.0);
  EXPECT_NEAR(rate_of("0.03"), 1.0 / 0.03, 1e-9) << "29 .. 40 Hz";
  EXPECT_NEAR(rate_of("0.0334"), 1.0 / 0.0334, 1e-9);
  EXPECT_NEAR(rate_of("0.03336666666666667"), 30000.0 / 1001.0, 1e-9);
  EXPECT_NEAR(rate_of("0.016683333333333335"), 60000.0 / 1001.0, 1e-9);
}

}  // namespace
}  // namespace kinegraph
