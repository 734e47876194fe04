// Files as other people's detectors write them, by hand.
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
#include "core/io/file_kind.h"
#include "core/io/files/text_file.h"
#include "tests/core/io/detections/detection_files.h"
#include "tests/support/hdf5_files.h"

namespace kinegraph {
namespace {

using testing::ExpectFault;
using testing::ExpectSameDetections;
using testing::FaultOf;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::JointOf;
using testing::RecordingIn;
using testing::TemporaryFolder;
using testing::WithReplaced;

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

TEST(DetectorFiles, MmposeInAllItsShapes) {
  const TemporaryFolder folder;
  const std::string list =
      "[{\"frame_id\": 7, \"instances\": [" + Instance(26) + "]}]";
  ExpectHalpe(RecordingIn("cam1.json", list), 7);
  ExpectHalpe(
      RecordingIn("with_meta.json",
                  "{\"meta_info\": {}, \"instance_info\": " + list + "}"),
      7);
  MakeFolder(folder.path() / "images/cam1");
  folder.Write("images/cam1/000012.json", "[" + Instance(26) + "]");
  ExpectHalpe(ReadDetections(folder.path() / "images"), 12);
}

TEST(DetectorFiles, MmposeSaysWhatIsWrong) {
  ExpectFault("odd.json",
              "[{\"frame_id\": 0, \"instances\": [" + Instance(19) + "]}]",
              "odd.json: entry 0: keypoints: found 19 joints");
  ExpectFault("mixed.json",
              "[{\"frame_id\": 0, \"instances\": [" + Instance(26) + ", " +
                  Instance(17) + "]}]",
              "keypoints: found 17 joints, expected 26");
}

// H36M's 17 are not COCO's, and no layout has CrowdPose's 14.
TEST(DetectorFiles, MmposeStatesItsJoints) {
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
      RecordingIn("a.json", file(h36m, 4)).header.skeleton;
  EXPECT_EQ(skeleton.name(), "h36m");
  EXPECT_EQ(skeleton.joints(), (std::vector<std::string>{"mid_hip", "r_hip",
                                                         "r_knee", "r_ankle"}));
  ASSERT_EQ(skeleton.bones().size(), 3u);
  EXPECT_EQ(skeleton.bones()[2].a, 2);
  EXPECT_EQ(skeleton.bones()[2].b, 3);
  const auto expect = [&](const std::string& meta, int joints,
                          const std::string& said) {
    ExpectFault("b.json", file(meta, joints), said);
  };
  expect(h36m, 5, "found 5 joints, expected 4");
  expect("\"keypoint_id2name\": {\"0\": \"a\", \"2\": \"b\"}", 2,
         "b.json: meta_info.keypoint_id2name: found '2', "
         "expected 0 .. 1");
  expect(
      "\"keypoint_id2name\": {\"0\": \"a\", \"1\": \"b\"}, "
      "\"skeleton_links\": [[0, 2]]",
      2, "meta_info.skeleton_links: found 2, expected 0 .. 1");
}

TEST(DetectorFiles, AlphaPoseNamesImagesAndHas26Joints) {
  std::string numbers = "1, 2, 0.5";
  for (int i = 1; i < 26; ++i) numbers += ", 3, 4, 0.5";
  const DetectionSequence recording =
      RecordingIn("cam1.json",
                  "[{\"image_id\": \"frame_000031.jpg\", \"category_id\": 1, "
                  "\"keypoints\": [" +
                      numbers +
                      "], \"score\": 2.1, \"box\": [1, 2, 3, 4], \"idx\": "
                      "0}]");
  EXPECT_TRUE(recording.header.skeleton == Halpe26());
  EXPECT_EQ(recording.frames[0].frame, 31);
}

constexpr const char* kDeepLabCut =
    "scorer,net,net,net,net,net,net\n"
    "bodyparts,left_hip,left_hip,left_hip,tail,tail,tail\n"
    "coords,x,y,likelihood,x,y,likelihood\n"
    "0,10.5,20,0.9,30,40,0.8\n"
    "1,11.5,21,0.9,,,\n";

TEST(DetectorFiles, DeepLabCutOfOne) {
  const DetectionSequence recording = RecordingIn("cam1.csv", kDeepLabCut);
  EXPECT_EQ(recording.header.skeleton.joints(),
            (std::vector<std::string>{"l_hip", "tail"}));
  ASSERT_EQ(recording.frames.size(), 2u);
  const auto& joints = recording.frames[1].views[0].detections.at(0).joints;
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
  const DetectionSequence recording = RecordingIn(
      "cam1.csv",
      "scorer,,,me,me,me,me\nindividuals,,,a,a,b,b\nbodyparts,,,nose,nose,nose,"
      "nose\ncoords,,,x,y,x,y\nlabeled-data,cam1,img0012.png,1,2,3,4\n");
  ASSERT_EQ(recording.frames.size(), 1u);
  EXPECT_EQ(recording.frames[0].frame, 12);
  ASSERT_EQ(recording.frames[0].views[0].detections.size(), 2u);
  EXPECT_EQ(recording.frames[0].views[0].detections[1].joints[0].px,
            Eigen::Vector2d(3, 4));
  EXPECT_EQ(recording.frames[0].views[0].detections[1].joints[0].confidence,
            1.0);
}

TEST(DetectorFiles, DeepLabCutSaysWhatIsWrong) {
  ExpectFault("a.csv", "scorer,n,n\n0,1,2\n",
              "a.csv: line 2: expected the header rows");
  ExpectFault("w.csv", "scorer,n\nbodyparts,a\nscorer,n,n\ncoords,x,y\n",
              "w.csv: line 3: found 3 cells, expected 2");
  ExpectFault("b.csv", std::string(kDeepLabCut) + "2,here,1,1,1,1,1\n",
              "b.csv: line 6: left_hip: found the text 'here', expected a "
              "number");
  ExpectFault("c.csv", std::string(kDeepLabCut) + "2,1\n",
              "c.csv: line 6: found 2 cells, expected 7");
}

std::vector<std::pair<int, int>> EndsOf(const Skeleton& skeleton) {
  std::vector<std::pair<int, int>> ends;
  for (const Bone& bone : skeleton.bones()) ends.emplace_back(bone.a, bone.b);
  return ends;
}

// Edges of the file, whatever a human has between joints of these names.
TEST(DetectorFiles, SleapHasItsOwnEdges) {
  testing::SleapFile file;
  file.nodes = {"left_shoulder", "left_elbow", "left_wrist"};
  file.edges = {2, 0, 0, 1};
  const std::vector<std::pair<int, int>> edges = {{2, 0}, {0, 1}};
  const auto skeleton = [&] {
    return RecordingIn("a.h5", testing::SleapHdf5(file)).header.skeleton;
  };
  EXPECT_EQ(EndsOf(skeleton()), edges);
  file.edges = {2, 0, 1, 0, 1, 2};  // as MATLAB has {2, 0}, {0, 1}, {1, 2}
  file.edge_sides = {2, 3};
  EXPECT_EQ(EndsOf(skeleton()),
            (std::vector<std::pair<int, int>>{{2, 0}, {0, 1}, {1, 2}}));
}

TEST(DetectorFiles, CocoHasItsOwnBones) {
  const Skeleton skeleton =
      RecordingIn("all.json",
                  "{\"images\": [{\"id\": 1, \"file_name\": \"cam1/1.jpg\"}], "
                  "\"annotations\": [], \"categories\": [{\"keypoints\": "
                  "[\"left_hip\", \"left_knee\", \"left_ankle\"], "
                  "\"skeleton\": [[3, 1]]}]}")
          .header.skeleton;
  EXPECT_EQ(EndsOf(skeleton), (std::vector<std::pair<int, int>>{{2, 0}}));
  EXPECT_EQ(skeleton.joints().front(), "l_hip");
}

TEST(DetectorFiles, MediaPipeTablesInPixelsAlone) {
  const std::string header =
      "frame,left_hip_x,left_hip_y,left_hip_visibility,right_hip_x,right_hip_y,"
      "right_hip_visibility\n";
  const DetectionSequence recording =
      RecordingIn("cam1.csv", header + "3,100,200,0.5,300,nan,0.5\n");
  EXPECT_EQ(recording.header.skeleton.joints(),
            (std::vector<std::string>{"l_hip", "r_hip"}));
  EXPECT_EQ(recording.frames.at(0).frame, 3);
  const auto& joints = recording.frames[0].views[0].detections.at(0).joints;
  EXPECT_EQ(joints[0].px, Eigen::Vector2d(100, 200));
  EXPECT_FALSE(joints[1].found);
  ExpectFault("cam2.csv", header + "3,0.5,0.25,0.5,0.75,0.25,0.5\n",
              "shares of the image, expected pixels");
}

// As Excel saves a table where numbers have decimal commas, and as editors
// leave it.
std::string Semicolons(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  std::replace(text.begin(), text.end(), '.', ',');
  return text;
}

std::string Carriage(const std::string& text, const std::string& end) {
  std::string other;
  for (const char c : text) other += c == '\n' ? end : std::string(1, c);
  return other;
}

TEST(DetectorFiles, TablesAsSpreadsheetsAndEditorsLeaveThem) {
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
  ExpectFault("unsure.csv", WithReplaced(kDeepLabCut, "11.5", "\"11,5\""),
              "unsure.csv: line 5: left_hip: found the text '11,5', "
              "expected a number with a decimal point");
  ExpectFault("wide.csv", std::string("\xff\xfes\0", 4),
              "wide.csv: is a text in UTF-16, expected UTF-8");
}

// Whether the first two joints are measurements.
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

// What detectors such as YOLO's write for joints that they do not see.
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
  std::string coco = "0, 0, 0.4";
  for (int j = 1; j < 17; ++j) coco += ", 10, 20, 0.5";
  std::string smap = "[0, 0, 1, 0.4]";
  for (int j = 1; j < 15; ++j) smap += ", [10, 30, 1, 0.5]";
  for (const auto& [name, text] :
       std::vector<std::pair<const char*, std::string>>{
           {"alphapose.json", R"([{"image_id": "7.jpg", "keypoints": [)" +
                                  coco + R"(], "score": 1, "idx": 0}])"},
           // Without confidences beside COCO's flags.
           {"views.json",
            R"({"images": [{"id": 1, "camera": "a", "frame": 7}], )"
            R"("annotations": [{"image_id": 1, "keypoints": [)" +
                coco + "]}]}"},
           {"deeplabcut.csv",
            "scorer,n,n,n,n,n,n\nbodyparts,a,a,a,b,b,b\ncoords,x,y,"
            "likelihood,x,y,likelihood\n7,0,0,0.4,10,20,0.5\n"},
           {"smap.json",
            R"({"3d_pairs": {"num": 1, "pred_2d": [[)" + smap + "]]}}"}}) {
    ExpectOnlySecond(folder.Write(name, text));
  }
}

// A recording of two views, `count` frames each, as our own detections.
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

TEST(DetectorFiles, SharesOfTheImageAreNoPixels) {
  const TemporaryFolder folder;
  const auto error_of = [&](int count, const std::string& first_view,
                            const std::string& second_view) {
    const std::string path =
        folder.Write("take.jsonl", RecordingOf(count, first_view, second_view));
    return InputErrorOf([&] { ReadDetections(path); });
  };
  const std::string shares = "[[0.5, 0.25, 1], [0.75, 0.5, 1]]";
  const std::string of_signs = "[[-0.75, 0.25, 1], [0.5, -0.5, 1]]";
  const std::string pixels = "[[0.5, 0.25, 1], [640, 360, 1]]";
  const std::string nobody = "[null, null]";
  EXPECT_THAT(error_of(1, shares, nobody),
              HasSubstr("take.jsonl: view 'cam1': positions are within x 0.5 "
                        ".. 0.75 and y 0.25 .. 0.5, shares of the image, "
                        "expected pixels: multiply x by the image's width"));
  EXPECT_THAT(error_of(3, of_signs, of_signs),
              HasSubstr("multiply (x + 1) / 2 by the image's width"));
  EXPECT_THAT(error_of(20, pixels, shares), HasSubstr("view 'cam2'"));
  EXPECT_THAT(error_of(20, "[[655360, 1e5, 1], [9e6, 1e6, 1]]", pixels),
              HasSubstr("view 'cam1': positions are within x 6.55e+05 .. 9e+06 "
                        "and y 1e+05 .. 1e+06, where no image reaches"));
  // Neither one person in the corner of a view, nor joints at a place that
  // stands for none.
  std::string odd = RecordingOf(20, pixels, pixels);
  odd.replace(odd.find(pixels), pixels.size(), shares);
  for (const std::string& recording :
       {odd, RecordingOf(20, pixels, pixels), RecordingOf(20, nobody, nobody),
        RecordingOf(20, "[[-1, -1, 0.1], [-1, -1, 0.1]]", pixels),
        RecordingOf(1, pixels, shares)}) {
    const std::string path = folder.Write("sound.jsonl", recording);
    EXPECT_GT(ReadDetections(path).frames.size(), 0u);
  }
}

// SLEAP's names move behind the numbers of a recording of more than two
// seconds.
TEST(DetectorFiles, SleapsFileIsAskedForItsNames) {
  const TemporaryFolder folder;
  testing::SleapFile content;
  content.sides = {3000, 1, 3, 2};
  content.other_sets = 12;
  const std::string bytes = testing::SleapHdf5(content);
  ASSERT_GT(bytes.find("node_names"), size_t{1} << 16);
  const std::string path = folder.Write("cam1.h5", bytes);
  EXPECT_EQ(RecogniseKind(path), FileKind::kDetections);
  EXPECT_EQ(ReadDetections(path).frames.size(), 3000u);
  FaultOf("half.h5", bytes.substr(0, 70000));
}

TEST(DetectorFiles, TimesAreNoFrameNumbers) {
  const TemporaryFolder folder;
  MakeFolder(folder.path() / "take");
  MakeFolder(folder.path() / "take/cam1");
  struct Case {
    const char* name;
    const char* said;
  };
  for (const Case& one :
       {Case{"cam1_1716223456789", "a time in milliseconds since 1970"},
        Case{"cam1_1716223456789012", "a time in microseconds since 1970"},
        Case{"1716223456789012345", "a time in nanoseconds"},
        Case{"20240520164416789", "a date and time"},
        Case{"cam1_1716223456.789012", "a time in seconds"},
        Case{"99999999999999999999", "holds no frame number"},
        Case{"calibration", "'calibration_keypoints.json' holds no frame"}}) {
    const std::string file =
        "take/cam1/" + std::string(one.name) + "_keypoints.json";
    folder.Write(file, R"({"people": []})");
    EXPECT_THAT(InputErrorOf([&] { ReadDetections(folder.path() / "take"); }),
                ::testing::AllOf(HasSubstr(one.name), HasSubstr(one.said)));
    std::filesystem::remove(folder.path() / file);
  }
  folder.Write("take/cam1/2024-05-20_000000000012_keypoints.json",
               R"({"people": []})");
  EXPECT_EQ(ReadDetections(folder.path() / "take").frames.at(0).frame, 12);
  std::string keypoints = "1";
  for (int n = 1; n < 51; ++n) keypoints += ", 1";
  const std::string path = folder.Write(
      "coco.json",
      R"([{"image_id": 1716223456789, "keypoints": [)" + keypoints + "]}]");
  DetectionReadOptions options;
  options.frame_rate_hz = 30.0;
  EXPECT_THAT(
      InputErrorOf([&] { ReadDetections(path, options); }),
      HasSubstr("coco.json: entry 0: frame 1716223456789: is too large"));
}

}  // namespace
}  // namespace kinegraph
