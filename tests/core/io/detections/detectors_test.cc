// Files as other people's detectors write them, by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/io/detections/source.h"
#include "core/io/files/text_file.h"
#include "core/io/text/joint_names.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

TEST(JointNames, AreKnownInManySpellings) {
  for (const char* label : {"left_shoulder", "LShoulder", "shoulder_left",
                            "Shoulder L", "l_shoulder", "L_Shoulder"}) {
    EXPECT_EQ(JointNameOf(label), "l_shoulder") << label;
  }
  EXPECT_EQ(JointNameOf("left_ear"), "l_ear");
  EXPECT_EQ(JointNameOf("right_eye_inner"), "r_eye_inner");
  EXPECT_EQ(JointNameOf("mouth_right"), "r_mouth");
  EXPECT_EQ(JointNameOf("RBigToe"), "r_big_toe");
  EXPECT_EQ(JointNameOf("Hip"), "mid_hip");
  EXPECT_EQ(JointNameOf("RHip"), "r_hip");
  EXPECT_EQ(JointNameOf("snout"), "snout");
  // Written names read back, for every joint of every built-in skeleton.
  for (const std::string& name : SkeletonNames()) {
    for (const std::string& joint : FindSkeleton(name)->joints()) {
      EXPECT_EQ(JointNameOf(LongJointName(joint)), joint);
    }
  }
}

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
