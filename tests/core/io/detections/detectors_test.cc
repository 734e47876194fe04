// Handwritten files in the formats of detectors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "core/io/detections/writer.h"
#include "core/io/files/text_file.h"
#include "tests/core/io/detections/detection_files.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using testing::ExpectFaults;
using testing::ExpectInputError;
using testing::ExpectSameDetections;
using testing::FaultOf;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::JointOf;
using testing::RecordingIn;
using testing::TemporaryFolder;
using testing::WithReplaced;

// `first`, followed by `next` up to `count` elements.
std::string Listed(const std::string& first, const std::string& next,
                   int count) {
  std::string text = first;
  for (int i = 1; i < count; ++i) text += ", " + next;
  return text;
}

// An instance whose last joint is at (125, 50.5) and whose first joint has
// score 0.
std::string Instance(int count) {
  return R"({"bbox": [[1, 2, 3, 4]], "bbox_score": 0.9, "keypoints": [)" +
         Listed("[100, 50.5]", "[9, 9]", count - 1) + ", [125, 50.5]" +
         R"(], "keypoint_scores": [)" + Listed("0", "0.75", count) + "]}";
}

void ExpectHalpe(const DetectionSequence& recording, int64_t frame) {
  EXPECT_TRUE(recording.header.skeleton == Halpe26());
  ASSERT_EQ(recording.frames.size(), 1u);
  EXPECT_EQ(recording.frames[0].frame, frame);
  ASSERT_EQ(recording.frames[0].views[0].detections.size(), 1u);
  const auto& joints = recording.frames[0].views[0].detections[0].joints;
  ASSERT_EQ(joints.size(), 26u);
  EXPECT_FALSE(joints[0].found) << "score 0";
  EXPECT_EQ(joints[25].px, Eigen::Vector2d(125, 50.5));
  EXPECT_EQ(joints[25].confidence, 0.75);
}

// A list with one frame.
std::string Mmpose(int64_t frame, const std::string& instances) {
  return R"([{"frame_id": )" + std::to_string(frame) + R"(, "instances": [)" +
         instances + "]}]";
}

TEST(DetectorFiles, MmposeIsReadAsListWithMetaAndPerImage) {
  const TemporaryFolder folder;
  const std::string list = Mmpose(7, Instance(26));
  ExpectHalpe(RecordingIn("cam1.json", list), 7);
  ExpectHalpe(
      RecordingIn("with_meta.json",
                  R"({"meta_info": {}, "instance_info": )" + list + "}"),
      7);
  MakeFolder(folder.path() / "images/cam1");
  folder.Write("images/cam1/000012.json", "[" + Instance(26) + "]");
  ExpectHalpe(ReadDetections(folder.path() / "images"), 12);
  folder.Write("objects/cam1/000012.json",
               R"({"meta_info": {}, "instance_info": [)" + Instance(26) + "]}");
  ExpectHalpe(ReadDetections(folder.path() / "objects"), 12);
}

TEST(DetectorFiles, MmposeErrorsNameTheEntry) {
  ExpectFaults("odd.json", {{Mmpose(0, Instance(19)),
                             "odd.json: entry 0: keypoints: found 19 joints"},
                            {Mmpose(0, Instance(26) + ", " + Instance(17)),
                             "keypoints: found 17 joints, expected 26"}});
}

// The number of joints does not identify a layout (H36M has 17 joints like
// COCO), so names in the file take precedence; here four of the H36M joints.
TEST(DetectorFiles, MmposeJointsFollowNamesInTheFile) {
  const auto file = [](const std::string& meta, int joints) {
    return R"({"meta_info": {)" + meta + R"(}, "instance_info": )" +
           Mmpose(0, Instance(joints)) + "}";
  };
  const std::string h36m =
      "\"dataset_name\": \"h36m\", \"keypoint_id2name\": {\"1\": "
      "\"right_hip\", \"0\": \"root\", \"2\": \"right_knee\", \"3\": "
      "\"right_foot\"}, \"skeleton_links\": [[0, 1], [1, 2], [2, 3]]";
  const Skeleton skeleton =
      RecordingIn("a.json", file(h36m, 4)).header.skeleton;
  EXPECT_EQ(skeleton.name(), "h36m");
  EXPECT_THAT(skeleton.joints(),
              ElementsAre("mid_hip", "r_hip", "r_knee", "r_ankle"));
  ASSERT_EQ(skeleton.bones().size(), 3u);
  EXPECT_EQ(skeleton.bones()[2].a, 2);
  EXPECT_EQ(skeleton.bones()[2].b, 3);
  const std::string two = R"("keypoint_id2name": {"0": "a", "1": "b"})";
  ExpectFaults(
      "b.json",
      {{file(h36m, 5), "found 5 joints, expected 4"},
       {file(WithReplaced(two, "1", "2"), 2),
        "b.json: meta_info.keypoint_id2name: found '2', expected 0 .. 1"},
       {file(two + R"(, "skeleton_links": [[0, 2]])", 2),
        "meta_info.skeleton_links: found 2, expected 0 .. 1"}});
}

TEST(DetectorFiles, AlphaPoseFrameFollowsFromImageName) {
  const DetectionSequence recording = RecordingIn(
      "cam1.json",
      R"([{"image_id": "frame_000031.jpg", "category_id": 1, "keypoints": [)" +
          Listed("1, 2, 0.5", "3, 4, 0.5", 26) +
          R"(], "score": 2.1, "box": [1, 2, 3, 4], "idx": 0}])");
  EXPECT_TRUE(recording.header.skeleton == Halpe26());
  EXPECT_EQ(recording.frames[0].frame, 31);
}

TEST(DetectorFiles, EmptyKeypointsKeepTheirIndex) {
  const std::string numbers = Listed("100, 200, 0.5", "300, 400, 0.5", 17);
  const std::string empty = R"("keypoints": []})";
  const std::string coco = R"({"image_id": 3, )";
  const std::string views = R"({"image_id": 1, )";
  for (const std::string& text :
       {"[" + coco + empty + ", " + coco + R"("keypoints": [)" + numbers +
            "]}]",
        Mmpose(3,
               R"({"keypoints": [], "keypoint_scores": []}, )" + Instance(26)),
        R"({"images": [{"id": 1, "camera": "a", "frame": 3}], )"
        R"("annotations": [)" +
            views + empty + ", " + views + R"("keypoints": [)" + numbers +
            "]}]}"}) {
    SCOPED_TRACE(text);
    const DetectionSequence recording = RecordingIn("cam1.json", text);
    ASSERT_EQ(recording.frames.size(), 1u);
    EXPECT_EQ(recording.frames[0].frame, 3);
    const auto& people = recording.frames[0].views[0].detections;
    ASSERT_EQ(people.size(), 1u);
    EXPECT_EQ(people[0].index_in_file, 1);
  }
}

constexpr const char* kDeepLabCut =
    "scorer,net,net,net,net,net,net\n"
    "bodyparts,left_hip,left_hip,left_hip,tail,tail,tail\n"
    "coords,x,y,likelihood,x,y,likelihood\n"
    "0,10.5,20,0.9,30,40,0.8\n"
    "1,11.5,21,0.9,,,\n";

TEST(DetectorFiles, DeepLabCutWithOneAnimalIsRead) {
  const DetectionSequence recording = RecordingIn("cam1.csv", kDeepLabCut);
  EXPECT_THAT(recording.header.skeleton.joints(), ElementsAre("l_hip", "tail"));
  ASSERT_EQ(recording.frames.size(), 2u);
  const Keypoint& hip = JointOf(recording, 1, 0, 0, 0);
  EXPECT_EQ(hip.px, Eigen::Vector2d(11.5, 21));
  EXPECT_EQ(hip.confidence, 0.9);
  EXPECT_FALSE(JointOf(recording, 1, 0, 0, 1).found);
}

// One network per camera, each with its own order of joints.
TEST(DetectorFiles, ViewsMustHaveTheSameJoints) {
  const TemporaryFolder folder;
  folder.Write("take/cam1.csv", kDeepLabCut);
  folder.Write("take/cam2.csv",
               "scorer,n,n,n,n\nbodyparts,tail,tail,left_hip,left_hip\n"
               "coords,x,y,x,y\n0,1,2,3,4\n");
  ExpectInputError([&] { ReadDetections(folder.path() / "take"); },
                   "cam2.csv: line 3: joint 0 is 'tail', expected 'left_hip' "
                   "as in the first file");
}

TEST(DetectorFiles, DeepLabCutWithSeveralAnimalsAndLabelledImagesIsRead) {
  const DetectionSequence recording = RecordingIn(
      "cam1.csv",
      "scorer,,,me,me,me,me\nindividuals,,,a,a,b,b\nbodyparts,,,nose,nose,nose,"
      "nose\ncoords,,,x,y,x,y\nlabeled-data,cam1,img0012.png,1,2,3,4\n");
  ASSERT_EQ(recording.frames.size(), 1u);
  EXPECT_EQ(recording.frames[0].frame, 12);
  ASSERT_EQ(recording.frames[0].views[0].detections.size(), 2u);
  EXPECT_EQ(JointOf(recording, 0, 0, 1, 0).px, Eigen::Vector2d(3, 4));
  EXPECT_EQ(JointOf(recording, 0, 0, 1, 0).confidence, 1.0);
}

TEST(DetectorFiles, DeepLabCutIndividualsLackUniqueBodyparts) {
  const std::string text =
      "scorer,me,me,me,me,me,me\nindividuals,a,a,a,single,single,single\n"
      "bodyparts,nose,nose,nose,ball,ball,ball\n"
      "coords,x,y,likelihood,x,y,likelihood\n7,100,200,0.5,300,400,0.5\n";
  const DetectionSequence recording = RecordingIn("cam1.csv", text);
  EXPECT_THAT(recording.header.skeleton.joints(), ElementsAre("nose", "ball"));
  ASSERT_EQ(recording.frames.at(0).views[0].detections.size(), 2u);
  EXPECT_FALSE(JointOf(recording, 0, 0, 0, 1).found);
  EXPECT_FALSE(JointOf(recording, 0, 0, 1, 0).found);
  EXPECT_EQ(JointOf(recording, 0, 0, 1, 1).px, Eigen::Vector2d(300, 400));
  ExpectFaults("cam2.csv",
               {{WithReplaced(text, "likelihood,x,y", "likelihood,x,z"),
                 "bodypart 'ball': expected the coords x and y"}});
}

TEST(DetectorFiles, DeepLabCutErrorsNameTheLine) {
  const std::string good = kDeepLabCut;
  ExpectFaults(
      "a.csv",
      {{"scorer,n,n\n0,1,2\n", "a.csv: line 2: expected the header rows"},
       {"scorer,n\nbodyparts,a\nscorer,n,n\ncoords,x,y\n",
        "a.csv: line 3: found 3 cells, expected 2"},
       {good + "2,here,1,1,1,1,1\n",
        "a.csv: line 6: left_hip: found the text 'here', expected a number"},
       {good + "2,1\n", "a.csv: line 6: found 2 cells, expected 7"}});
}

std::vector<std::pair<int, int>> EndsOf(const Skeleton& skeleton) {
  std::vector<std::pair<int, int>> ends;
  for (const Bone& bone : skeleton.bones()) ends.emplace_back(bone.a, bone.b);
  return ends;
}

TEST(DetectorFiles, CocoBonesFollowTheFile) {
  const Skeleton skeleton =
      RecordingIn("all.json",
                  R"({"images": [{"id": 1, "file_name": "cam1/1.jpg"}], )"
                  R"("annotations": [], "categories": [{"keypoints": )"
                  R"(["left_hip", "left_knee", "left_ankle"], )"
                  R"("skeleton": [[3, 1]]}]})")
          .header.skeleton;
  EXPECT_EQ(EndsOf(skeleton), (std::vector<std::pair<int, int>>{{2, 0}}));
  EXPECT_EQ(skeleton.joints().front(), "l_hip");
}

TEST(DetectorFiles, MediaPipeTablesMustBeInPixels) {
  const std::string header =
      "frame,left_hip_x,left_hip_y,left_hip_visibility,right_hip_x,right_hip_y,"
      "right_hip_visibility\n";
  const DetectionSequence recording =
      RecordingIn("cam1.csv", header + "3,100,200,0.5,300,nan,0.5\n");
  EXPECT_THAT(recording.header.skeleton.joints(),
              ElementsAre("l_hip", "r_hip"));
  EXPECT_EQ(recording.frames.at(0).frame, 3);
  EXPECT_EQ(JointOf(recording, 0, 0, 0, 0).px, Eigen::Vector2d(100, 200));
  EXPECT_FALSE(JointOf(recording, 0, 0, 0, 1).found);
  ExpectFaults("cam2.csv", {{header + "3,0.5,0.25,0.5,0.75,0.25,0.5\n",
                             "normalised by the image size, expected pixels"}});
}

TEST(DetectorFiles, FrameNumbersOfTablesAreWhole) {
  const std::string table = "frame,left_hip_x,left_hip_y\n";
  const std::string cells = ",100,200\n";
  for (const auto& [cell, frame] :
       {std::pair{"1e5", 100000}, {"12.0", 12}, {"img0012.png", 12}}) {
    EXPECT_EQ(RecordingIn("cam1.csv", table + cell + cells).frames.at(0).frame,
              frame);
  }
  const std::string deeplabcut = kDeepLabCut;
  ExpectFaults(
      "cam1.csv",
      {{table + "-2" + cells, "line 2: frame: found '-2', expected a whole"},
       {table + "2.5" + cells, "line 2: frame: found '2.5'"},
       {table + "1.716223456789e12" + cells, "a time in milliseconds"},
       {deeplabcut + "-1,1,1,1,1,1,1\n", "line 6: frame: found '-1'"}});
}

TEST(DetectorFiles, MediaPipeTablesMayHaveOtherScores) {
  const DetectionSequence recording =
      RecordingIn("cam1.csv",
                  "frame,person_score,nose_x,nose_y,nose_score\n"
                  "3,0.9,100,200,0.5\n");
  EXPECT_THAT(recording.header.skeleton.joints(), ElementsAre("nose"));
  EXPECT_EQ(JointOf(recording, 0, 0, 0, 0).confidence, 0.5);
  ExpectFaults("cam2.csv", {{"frame,nose_x,nose_score\n3,100,0.5\n",
                             "joint 'nose': expected the columns _x and _y"}});
}

// The table as saved by Excel with decimal commas.
std::string Semicolons(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  std::replace(text.begin(), text.end(), '.', ',');
  return text;
}

// The text with other line ends.
std::string Carriage(const std::string& text, const std::string& end) {
  std::string other;
  for (const char c : text) other += c == '\n' ? end : std::string(1, c);
  return other;
}

TEST(DetectorFiles, TablesOfSpreadsheetsAndEditorsAreRead) {
  const std::string mark = "\xef\xbb\xbf";
  for (const std::string text :
       {kDeepLabCut,
        "frame,left_hip_x,left_hip_y,left_hip_visibility\n3,100.5,200,0.5\n"
        "5,102.5,201,0.25\n"}) {
    const DetectionSequence plain = RecordingIn("x.csv", text);
    std::string tabs = text;
    std::replace(tabs.begin(), tabs.end(), ',', '\t');
    for (const std::string& other :
         {mark + text, Carriage(text, "\r\n"), Carriage(text, "\r"),
          mark + Carriage(text, "\r\n"), Semicolons(text), tabs,
          mark + Carriage(Semicolons(text), "\r\n"), "sep=,\n" + text,
          "sep=;\r\n" + Carriage(Semicolons(text), "\r\n"), text + "\n\n"}) {
      SCOPED_TRACE(other);
      ExpectSameDetections(plain, RecordingIn("x.csv", other));
    }
  }
  ExpectFaults("unsure.csv",
               {{WithReplaced(kDeepLabCut, "11.5", "\"11,5\""),
                 "unsure.csv: line 5: left_hip: found the text '11,5', "
                 "expected a number with a decimal point"},
                {std::string("\xff\xfes\0", 4),
                 "unsure.csv: is UTF-16 text, expected UTF-8"}});
}

// Expects the first joint, at (0, 0), to be found only if zeros are positions,
// and the second always.
void ExpectOnlySecond(const std::string& path) {
  SCOPED_TRACE(path);
  for (const ZeroConfidence zero :
       {ZeroConfidence::kMissing, ZeroConfidence::kPosition}) {
    DetectionReadOptions options;
    options.zero_confidence = zero;
    const DetectionSequence recording = ReadDetections(path, options);
    EXPECT_EQ(JointOf(recording, 0, 0, 0, 0).found,
              zero == ZeroConfidence::kPosition);
    EXPECT_TRUE(JointOf(recording, 0, 0, 0, 1).found);
  }
}

// Detectors such as YOLO's write zeros for joints that they do not find.
TEST(DetectorFiles, JointsAtZeroAreMissingInEveryFormat) {
  const TemporaryFolder folder;
  for (const Skeleton* skeleton : {&Coco17(), &Tum14()}) {
    DetectionSequence sequence;
    sequence.header = {*skeleton, {"a"}, 25.0};
    sequence.frames.resize(1);
    sequence.frames[0].views.resize(1);
    Detection person;
    person.joints.resize(skeleton->joints().size(), {{10, 20}, 0.5, true});
    person.joints[0] = {{0, 0}, 0.4, true};
    sequence.frames[0].views[0].detections = {person};
    const std::string own = folder.path() / (skeleton->name() + "_own.jsonl");
    WriteDetections(own, sequence);
    DetectionReadOptions options;
    options.zero_confidence = ZeroConfidence::kPosition;
    for (const DetectionFormat& format : DetectionFormats()) {
      if (format.write == nullptr ||
          (format.name == "longcw") != (skeleton == &Tum14())) {
        continue;
      }
      const std::string path = folder.path() / format.name;
      LostFields lost_fields;
      format.write(path, {{640, 480}}, OpenDetections(own, options).get(),
                   &lost_fields);
      ExpectOnlySecond(path);
    }
  }
  const std::string coco = Listed("0, 0, 0.4", "10, 20, 0.5", 17);
  for (const auto& [name, text] :
       std::vector<std::pair<const char*, std::string>>{
           {"alphapose.json", R"([{"image_id": "7.jpg", "keypoints": [)" +
                                  coco + R"(], "score": 1, "idx": 0}])"},
           // Confidences in place of COCO's visibility flags.
           {"views.json",
            R"({"images": [{"id": 1, "camera": "a", "frame": 7}], )"
            R"("annotations": [{"image_id": 1, "keypoints": [)" +
                coco + "]}]}"},
           {"deeplabcut.csv",
            "scorer,n,n,n,n,n,n\nbodyparts,a,a,a,b,b,b\ncoords,x,y,"
            "likelihood,x,y,likelihood\n7,0,0,0.4,10,20,0.5\n"}}) {
    ExpectOnlySecond(folder.Write(name, text));
  }
}

// A recording of two views with `count` frames each, in kinegraph's format.
std::string RecordingOf(int count, const std::string& first_view,
                        const std::string& second_view) {
  std::string text =
      R"({"kinegraph_detections": 1, "skeleton": {"name": "two", "joints": )"
      R"(["a", "b"], "bones": []}, "views": ["cam1", "cam2"]})"
      "\n";
  for (int f = 0; f < count; ++f) {
    text += R"({"frame": )" + std::to_string(f) +
            R"(, "views": {"cam1": [{"joints": )" + first_view +
            R"(}], "cam2": [{"joints": )" + second_view + "}]}}\n";
  }
  return text;
}

TEST(DetectorFiles, RejectsNormalisedPositions) {
  const std::string shares = "[[0.5, 0.25, 1], [0.75, 0.5, 1]]";
  const std::string of_signs = "[[-0.75, 0.25, 1], [0.5, -0.5, 1]]";
  const std::string pixels = "[[0.5, 0.25, 1], [640, 360, 1]]";
  const std::string nobody = "[null, null]";
  ExpectFaults(
      "take.jsonl",
      {{RecordingOf(1, shares, nobody),
        "take.jsonl: view 'cam1': positions are within x 0.5 .. 0.75 and y "
        "0.25 .. 0.5, which are normalised by the image size, expected pixels: "
        "multiply x by the image's width"},
       {RecordingOf(3, of_signs, of_signs),
        "multiply (x + 1) / 2 by the image's width"},
       {RecordingOf(20, pixels, shares), "view 'cam2'"},
       {RecordingOf(20, "[[655360, 1e5, 1], [9e6, 1e6, 1]]", pixels),
        "view 'cam1': positions are within x 6.55e+05 .. 9e+06 and y 1e+05 .. "
        "1e+06, outside any possible image"},
       {RecordingOf(1, "[[655360, 1e5, 1], [9e6, 1e6, 1]]", nobody),
        "outside any possible image"}});
  // Accepted: a person in the corner of a view, pixels in both views, no found
  // joints, and joints at a position that represents missing joints.
  const std::string odd =
      WithReplaced(RecordingOf(20, pixels, pixels), pixels, shares);
  for (const std::string& recording :
       {odd, RecordingOf(20, pixels, pixels), RecordingOf(20, nobody, nobody),
        RecordingOf(20, "[[-1, -1, 0.1], [-1, -1, 0.1]]", pixels),
        RecordingOf(1, pixels, shares)}) {
    EXPECT_GT(RecordingIn("sound.jsonl", recording).frames.size(), 0u);
  }
}

TEST(DetectorFiles, RejectsTimesAsFrameNumbers) {
  const TemporaryFolder folder;
  for (const auto& [name, said] :
       {std::pair{"cam1_1716223456789", "a time in milliseconds since 1970"},
        {"cam1_1716223456789012", "a time in microseconds since 1970"},
        {"1716223456789012345", "a time in nanoseconds"},
        {"20240520164416789", "a date and time"},
        {"cam1_1716223456.789012", "a time in seconds"},
        {"99999999999999999999", "contains no frame number"},
        {"calibration", "'calibration_keypoints.json' contains no frame"}}) {
    const std::string file =
        "take/cam1/" + std::string(name) + "_keypoints.json";
    folder.Write(file, R"({"people": []})");
    EXPECT_THAT(InputErrorOf([&] { ReadDetections(folder.path() / "take"); }),
                ::testing::AllOf(HasSubstr(name), HasSubstr(said)));
    std::filesystem::remove(folder.path() / file);
  }
  folder.Write("take/cam1/2024-05-20_000000000012_keypoints.json",
               R"({"people": []})");
  EXPECT_EQ(ReadDetections(folder.path() / "take").frames.at(0).frame, 12);
  DetectionReadOptions options;
  options.frame_rate_hz = 30.0;
  ExpectFaults("coco.json",
               {{R"([{"image_id": 1716223456789, "keypoints": [)" +
                     Listed("1", "1", 51) + "]}]",
                 "coco.json: entry 0: frame 1716223456789: is too large"}},
               options);
}

}  // namespace
}  // namespace kinegraph
