// Files as other people's detectors write them, by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "core/io/detections/source.h"
#include "core/io/files/text_file.h"
#include "tests/core/io/input_error.h"
#include "tests/support/hdf5_files.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

std::string Points(int count) {
  std::string text = "[";
  for (int i = 0; i < count; ++i) {
    text += (i > 0 ? ", [" : "[") + std::to_string(100 + i) + ", 50.5]";
  }
  return text + "]";
}

std::string Scores(int count) {
  std::string text = "[0";
  for (int i = 1; i < count; ++i) text += ", 0.75";
  return text + "]";
}

std::string Instance(int count) {
  return "{\"bbox\": [[1, 2, 3, 4]], \"bbox_score\": 0.9, \"keypoints\": " +
         Points(count) + ", \"keypoint_scores\": " + Scores(count) + "}";
}

void ExpectHalpe(const DetectionSequence& take, int64_t frame) {
  EXPECT_TRUE(take.header.skeleton == Halpe26());
  ASSERT_EQ(take.frames.size(), 1u);
  EXPECT_EQ(take.frames[0].frame, frame);
  ASSERT_EQ(take.frames[0].views[0].detections.size(), 1u);
  const auto& joints = take.frames[0].views[0].detections[0].joints;
  ASSERT_EQ(joints.size(), 26u);
  EXPECT_FALSE(joints[0].found) << "score 0";
  EXPECT_EQ(joints[25].px, Eigen::Vector2d(125, 50.5));
  EXPECT_EQ(joints[25].confidence, 0.75);
}

TEST(DetectorFiles, MmposeInAllItsShapes) {
  const TemporaryFolder folder;
  const std::string list =
      "[{\"frame_id\": 7, \"instances\": [" + Instance(26) + "]}]";
  ExpectHalpe(ReadDetections(folder.Write("cam1.json", list)), 7);
  ExpectHalpe(ReadDetections(folder.Write(
                  "with_meta.json",
                  "{\"meta_info\": {}, \"instance_info\": " + list + "}")),
              7);
  MakeFolder(folder.path() / "images/cam1");
  folder.Write("images/cam1/000012.json", "[" + Instance(26) + "]");
  ExpectHalpe(ReadDetections(folder.path() / "images"), 12);
}

TEST(DetectorFiles, MmposeSaysWhatIsWrong) {
  const TemporaryFolder folder;
  EXPECT_THAT(InputErrorOf([&] {
                ReadDetections(folder.Write(
                    "odd.json", "[{\"frame_id\": 0, \"instances\": [" +
                                    Instance(19) + "]}]"));
              }),
              HasSubstr("odd.json: entry 0: keypoints: found 19 joints"));
  EXPECT_THAT(
      InputErrorOf([&] {
        ReadDetections(folder.Write(
            "mixed.json", "[{\"frame_id\": 0, \"instances\": [" + Instance(26) +
                              ", " + Instance(17) + "]}]"));
      }),
      HasSubstr("keypoints: found 17 joints, expected 26"));
}

// H36M's 17 are not COCO's, and no layout has CrowdPose's 14.
TEST(DetectorFiles, MmposeStatesItsJoints) {
  const TemporaryFolder folder;
  const auto file = [](const std::string& meta, int joints) {
    return "{\"meta_info\": {" + meta +
           "}, \"instance_info\": [{\"frame_id\": 0, \"instances\": [" +
           Instance(joints) + "]}]}";
  };
  const std::string h36m =
      "\"dataset_name\": \"h36m\", \"keypoint_id2name\": {\"1\": "
      "\"right_hip\", \"0\": \"root\", \"2\": \"right_knee\", \"3\": "
      "\"right_foot\"}, \"skeleton_links\": [[0, 1], [1, 2], [2, 3]]";
  const Skeleton skeleton =
      ReadDetections(folder.Write("a.json", file(h36m, 4))).header.skeleton;
  EXPECT_EQ(skeleton.name(), "h36m");
  EXPECT_EQ(skeleton.joints(), (std::vector<std::string>{"mid_hip", "r_hip",
                                                         "r_knee", "r_ankle"}));
  ASSERT_EQ(skeleton.bones().size(), 3u);
  EXPECT_EQ(skeleton.bones()[2].a, 2);
  EXPECT_EQ(skeleton.bones()[2].b, 3);
  const auto error = [&](const std::string& meta, int joints) {
    return InputErrorOf(
        [&] { ReadDetections(folder.Write("b.json", file(meta, joints))); });
  };
  EXPECT_THAT(error(h36m, 5), HasSubstr("found 5 joints, expected 4"));
  EXPECT_THAT(error("\"keypoint_id2name\": {\"0\": \"a\", \"2\": \"b\"}", 2),
              HasSubstr("b.json: meta_info.keypoint_id2name: found '2', "
                        "expected 0 .. 1"));
  EXPECT_THAT(error("\"keypoint_id2name\": {\"0\": \"a\", \"1\": \"b\"}, "
                    "\"skeleton_links\": [[0, 2]]",
                    2),
              HasSubstr("meta_info.skeleton_links: found 2, expected 0 .. 1"));
}

TEST(DetectorFiles, AlphaPoseNamesImagesAndHas26Joints) {
  const TemporaryFolder folder;
  std::string numbers = "1, 2, 0.5";
  for (int i = 1; i < 26; ++i) numbers += ", 3, 4, 0.5";
  const DetectionSequence take = ReadDetections(
      folder.Write("cam1.json",
                   "[{\"image_id\": \"frame_000031.jpg\", \"category_id\": 1, "
                   "\"keypoints\": [" +
                       numbers +
                       "], \"score\": 2.1, \"box\": [1, 2, 3, 4], \"idx\": "
                       "0}]"));
  EXPECT_TRUE(take.header.skeleton == Halpe26());
  EXPECT_EQ(take.frames[0].frame, 31);
}

constexpr const char* kDeepLabCut =
    "scorer,net,net,net,net,net,net\n"
    "bodyparts,left_hip,left_hip,left_hip,tail,tail,tail\n"
    "coords,x,y,likelihood,x,y,likelihood\n"
    "0,10.5,20,0.9,30,40,0.8\n"
    "1,11.5,21,0.9,,,\n";

TEST(DetectorFiles, DeepLabCutOfOne) {
  const TemporaryFolder folder;
  const DetectionSequence take =
      ReadDetections(folder.Write("cam1.csv", kDeepLabCut));
  EXPECT_EQ(take.header.skeleton.joints(),
            (std::vector<std::string>{"l_hip", "tail"}));
  ASSERT_EQ(take.frames.size(), 2u);
  const auto& joints = take.frames[1].views[0].detections.at(0).joints;
  EXPECT_EQ(joints[0].px, Eigen::Vector2d(11.5, 21));
  EXPECT_EQ(joints[0].confidence, 0.9);
  EXPECT_FALSE(joints[1].found);
}

// A network a camera, and each with an order of its own.
TEST(DetectorFiles, ViewsHaveTheSameJoints) {
  const TemporaryFolder folder;
  MakeFolder(folder.path() / "take");
  folder.Write("take/cam1.csv", kDeepLabCut);
  folder.Write("take/cam2.csv",
               "scorer,n,n,n,n\nbodyparts,tail,tail,left_hip,left_hip\n"
               "coords,x,y,x,y\n0,1,2,3,4\n");
  EXPECT_THAT(InputErrorOf([&] { ReadDetections(folder.path() / "take"); }),
              HasSubstr("cam2.csv: line 3: joint 0 is 'tail', expected "
                        "'left_hip' as in the first file"));
}

TEST(DetectorFiles, DeepLabCutOfSeveralAndLabelledImages) {
  const TemporaryFolder folder;
  const DetectionSequence take = ReadDetections(folder.Write(
      "cam1.csv",
      "scorer,,,me,me,me,me\nindividuals,,,a,a,b,b\nbodyparts,,,nose,nose,nose,"
      "nose\ncoords,,,x,y,x,y\nlabeled-data,cam1,img0012.png,1,2,3,4\n"));
  ASSERT_EQ(take.frames.size(), 1u);
  EXPECT_EQ(take.frames[0].frame, 12);
  ASSERT_EQ(take.frames[0].views[0].detections.size(), 2u);
  EXPECT_EQ(take.frames[0].views[0].detections[1].joints[0].px,
            Eigen::Vector2d(3, 4));
  EXPECT_EQ(take.frames[0].views[0].detections[1].joints[0].confidence, 1.0);
}

TEST(DetectorFiles, DeepLabCutSaysWhatIsWrong) {
  const TemporaryFolder folder;
  EXPECT_THAT(InputErrorOf([&] {
                ReadDetections(folder.Write("a.csv", "scorer,n,n\n0,1,2\n"));
              }),
              HasSubstr("a.csv: line 2: expected the header rows"));
  EXPECT_THAT(
      InputErrorOf([&] {
        ReadDetections(folder.Write(
            "w.csv", "scorer,n\nbodyparts,a\nscorer,n,n\ncoords,x,y\n"));
      }),
      HasSubstr("w.csv: line 3: found 3 cells, expected 2"));
  EXPECT_THAT(
      InputErrorOf([&] {
        ReadDetections(folder.Write(
            "b.csv", std::string(kDeepLabCut) + "2,here,1,1,1,1,1\n"));
      }),
      HasSubstr("b.csv: line 6: left_hip: found the text 'here', expected a "
                "number"));
  EXPECT_THAT(InputErrorOf([&] {
                ReadDetections(
                    folder.Write("c.csv", std::string(kDeepLabCut) + "2,1\n"));
              }),
              HasSubstr("c.csv: line 6: found 2 cells, expected 7"));
}

std::vector<std::pair<int, int>> EndsOf(const Skeleton& skeleton) {
  std::vector<std::pair<int, int>> ends;
  for (const Bone& bone : skeleton.bones()) ends.emplace_back(bone.a, bone.b);
  return ends;
}

// Edges of the file, whatever a human has between joints of these names.
TEST(DetectorFiles, SleapHasItsOwnEdges) {
  const TemporaryFolder folder;
  testing::SleapFile file;
  file.nodes = {"left_shoulder", "left_elbow", "left_wrist"};
  file.edges = {2, 0, 0, 1};
  const std::vector<std::pair<int, int>> edges = {{2, 0}, {0, 1}};
  const auto skeleton = [&] {
    return ReadDetections(folder.Write("a.h5", testing::SleapHdf5(file)))
        .header.skeleton;
  };
  EXPECT_EQ(EndsOf(skeleton()), edges);
  file.edges = {2, 0, 1, 0, 1, 2};  // as MATLAB has {2, 0}, {0, 1}, {1, 2}
  file.edge_sides = {2, 3};
  EXPECT_EQ(EndsOf(skeleton()),
            (std::vector<std::pair<int, int>>{{2, 0}, {0, 1}, {1, 2}}));
}

TEST(DetectorFiles, CocoHasItsOwnBones) {
  const TemporaryFolder folder;
  const Skeleton skeleton =
      ReadDetections(
          folder.Write(
              "all.json",
              "{\"images\": [{\"id\": 1, \"file_name\": \"cam1/1.jpg\"}], "
              "\"annotations\": [], \"categories\": [{\"keypoints\": "
              "[\"left_hip\", \"left_knee\", \"left_ankle\"], "
              "\"skeleton\": [[3, 1]]}]}"))
          .header.skeleton;
  EXPECT_EQ(EndsOf(skeleton), (std::vector<std::pair<int, int>>{{2, 0}}));
  EXPECT_EQ(skeleton.joints().front(), "l_hip");
}

TEST(DetectorFiles, MediaPipeTablesInPixelsAlone) {
  const TemporaryFolder folder;
  const std::string header =
      "frame,left_hip_x,left_hip_y,left_hip_visibility,right_hip_x,right_hip_y,"
      "right_hip_visibility\n";
  const DetectionSequence take = ReadDetections(
      folder.Write("cam1.csv", header + "3,100,200,0.5,300,nan,0.5\n"));
  EXPECT_EQ(take.header.skeleton.joints(),
            (std::vector<std::string>{"l_hip", "r_hip"}));
  EXPECT_EQ(take.frames.at(0).frame, 3);
  const auto& joints = take.frames[0].views[0].detections.at(0).joints;
  EXPECT_EQ(joints[0].px, Eigen::Vector2d(100, 200));
  EXPECT_FALSE(joints[1].found);
  EXPECT_THAT(InputErrorOf([&] {
                ReadDetections(folder.Write(
                    "cam2.csv", header + "3,0.5,0.25,0.5,0.75,0.25,0.5\n"));
              }),
              HasSubstr("within the unit square, expected pixels"));
}

}  // namespace
}  // namespace kinegraph
