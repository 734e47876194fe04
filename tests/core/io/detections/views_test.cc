// Files and folders of several cameras, and of several detectors for one
// camera: handwritten, and public samples.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "core/io/file_kind.h"
#include "core/io/files/text_file.h"
#include "core/io/tracks/tracks.h"
#include "tests/core/io/detections/detection_files.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using testing::ExpectFaults;
using testing::ExpectInputError;
using testing::FaultOf;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::JointOf;
using testing::RecordingIn;
using testing::TemporaryFolder;
using testing::WithReplaced;

// ---- One COCO file for several cameras ----

constexpr const char* kCoco = R"({"info": {"frame_rate": 50}, "categories": [
{"id": 9, "name": "box"},
{"id": 1, "name": "person", "keypoints": ["nose", "tail", "left_knee"],
 "skeleton": [[1, 2], [2, 3]]}],
"images": [{"id": 11, "file_name": "take/cam10/000005.jpg"},
{"id": 12, "file_name": "take/cam2/000005.jpg"},
{"id": 13, "file_name": "x.jpg", "camera": "cam2", "frame_id": 7}],
"annotations": [
{"id": 1, "image_id": 12, "keypoints": [10, 20, 2, 0, 0, 0, 30.5, 40, 1]},
{"id": 2, "image_id": 12, "category_id": 9, "bbox": [1, 2, 3, 4]},
{"id": 3, "image_id": 13, "keypoints": [1, 2, 0.25, 3, 4, 2, 0, 0, 0],
 "keypoint_scores": [0.5, 0.75, 0]}]})";

TEST(CocoViews, CamerasAndFramesFollowTheImages) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("take.json", kCoco);
  EXPECT_EQ(RecogniseKind(path), FileKind::kDetections);
  const DetectionSequence recording = ReadDetections(path);
  EXPECT_EQ(recording.header.frame_rate_hz, 50.0);
  EXPECT_THAT(recording.header.view_names, ElementsAre("cam2", "cam10"));
  EXPECT_THAT(recording.header.skeleton.joints(),
              ElementsAre("nose", "tail", "l_knee"));
  ASSERT_EQ(recording.header.skeleton.bones().size(), 2u);
  EXPECT_EQ(recording.header.skeleton.bones()[1].a, 1);
  ASSERT_EQ(recording.frames.size(), 2u);
  EXPECT_EQ(recording.frames[0].frame, 5);
  EXPECT_EQ(recording.frames[1].frame, 7);
  EXPECT_TRUE(recording.frames[0].views[1].detections.empty())
      << "no person in cam10";
  EXPECT_EQ(JointOf(recording, 0, 0, 0, 0).px, Eigen::Vector2d(10, 20));
  EXPECT_EQ(JointOf(recording, 0, 0, 0, 0).confidence, 1.0) << "flag 2";
  EXPECT_FALSE(JointOf(recording, 0, 0, 0, 1).found) << "flag 0";
  EXPECT_EQ(JointOf(recording, 0, 0, 0, 2).confidence, 1.0) << "flag 1";
  EXPECT_EQ(JointOf(recording, 1, 0, 0, 0).confidence, 0.5) << "scores count";
  EXPECT_FALSE(JointOf(recording, 1, 0, 0, 2).found);
}

TEST(CocoViews, AnotherRateOverridesTheFilesOrIsRefused) {
  DetectionReadOptions options;
  options.frame_rate_hz = 30.0;
  EXPECT_EQ(RecordingIn("take.json", kCoco, options).header.frame_rate_hz,
            30.0);
  options.refuse_other_rate = true;
  EXPECT_THAT(FaultOf("take.json", kCoco, options),
              HasSubstr("take.json: --frame_rate=30 is for input that does not "
                        "specify its rate, but the input specifies 50 Hz"));
  // Within 1 % of the file's 50 Hz, so not another rate (AreOtherRates).
  options.frame_rate_hz = 49.95;
  EXPECT_EQ(RecordingIn("take.json", kCoco, options).header.frame_rate_hz,
            49.95);
  const std::string without =
      WithReplaced(kCoco, "\"frame_rate\": 50", "\"version\": 1");
  options.frame_rate_hz = 30.0;
  EXPECT_EQ(RecordingIn("take.json", without, options).header.frame_rate_hz,
            30.0);
}

TEST(CocoViews, ErrorsNameTheFault) {
  const auto with = [](const std::string& from, const std::string& to) {
    return WithReplaced(kCoco, from, to);
  };
  ExpectFaults(
      "broken.json",
      {{with("\"id\": 12", "\"id\": 11"),
        "broken.json: image 1: id 11 appears twice"},
       {with("take/cam10/000005.jpg", "000005.jpg"),
        "image 0: expected the key 'camera', 'view', 'camera_id' or 'cam_id', "
        "or a folder"},
       {with("take/cam10/000005.jpg", "cam10/a.jpg"),
        "image 0: 'a.jpg' contains no frame number"},
       {with("\"image_id\": 13", "\"image_id\": 14"),
        "annotation 2: image_id 14 does not occur in images"},
       {with("[10, 20, 2, 0", "[10, 20, 0"), "annotation 0: keypoints"},
       {with("[2, 3]]", "[2, 4]]"), "skeleton"},
       {with("[2, 3]]", "[127777777777, 3]]"),
        "skeleton: found 127777777777, expected 1 .. 3"}});
}

// ---- FreeMoCap's array ----

std::string Npy(const std::string& shape, const std::vector<double>& numbers) {
  std::string header =
      "{'descr': '<f8', 'fortran_order': False, 'shape': (" + shape + "), }";
  while ((10 + header.size() + 1) % 64 != 0) header += ' ';
  header += '\n';
  std::string file("\x93NUMPY\x01\x00", 8);
  file += static_cast<char>(header.size() % 256);
  file += static_cast<char>(header.size() / 256);
  file += header;
  return file.append(reinterpret_cast<const char*>(numbers.data()),
                     numbers.size() * sizeof(double));
}

TEST(FreeMoCap, BodyIsTheFirstPartOfThePoints) {
  constexpr size_t kPoints = 75;  // body and hands
  std::vector<double> numbers(2 * 3 * kPoints * 2);
  std::iota(numbers.begin(), numbers.end(), 0.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  numbers[0] = numbers[1] = nan;
  // No person in the second camera's last frame.
  std::fill(numbers.begin() + 5 * kPoints * 2, numbers.end(), nan);
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("take_pixelXY.npy", Npy("2, 3, 75, 2", numbers));
  EXPECT_EQ(RecogniseKind(path), FileKind::kDetections);
  DetectionReadOptions options;
  options.frame_rate_hz = 30.0;
  const DetectionSequence recording = ReadDetections(path, options);
  EXPECT_TRUE(recording.header.skeleton == MediaPipe33());
  EXPECT_THAT(recording.header.view_names, ElementsAre("cam_0", "cam_1"));
  ASSERT_EQ(recording.frames.size(), 3u);
  EXPECT_FALSE(JointOf(recording, 0, 0, 0, 0).found);
  EXPECT_EQ(JointOf(recording, 0, 0, 0, 1).px, Eigen::Vector2d(2, 3));
  // Camera 1, frame 1, point 32.
  const double x = (1 * 3 + 1) * 150 + 64;
  EXPECT_EQ(JointOf(recording, 1, 1, 0, 32).px, Eigen::Vector2d(x, x + 1));
  EXPECT_TRUE(recording.frames[2].views[1].detections.empty());
}

TEST(FreeMoCap, ErrorsNameTheFault) {
  DetectionReadOptions options;
  options.format = "freemocap";
  const std::vector<double> sixteen(16);
  ExpectFaults("a.npy",
               {{Npy("4, 4", sixteen), "has 2 dimensions, expected 4"},
                {Npy("1, 1, 4, 4", sixteen), "[cameras, frames, points, 2]"},
                {Npy("1, 1, 8, 2", sixteen), "points: found 8 joints"},
                {Npy("1, 1, 9, 2", sixteen), "is truncated"}},
               options);
}

// FreeMoCap's 3D output, as a table and as an array.
TEST(FreeMoCap, PointsIn3dAreTracks) {
  const TemporaryFolder folder;
  const std::string table =
      folder.Write("mediapipe_body_3d_xyz.csv",
                   "nose_x,nose_y,nose_z,left_hip_x,left_hip_y,left_hip_z\n"
                   "100,200,300,,,\n1000,-2000,3000,1,2,3\n,,,,,\n");
  EXPECT_EQ(RecogniseKind(table), FileKind::kTracks);
  TrackReadOptions options;
  options.frame_rate_hz = 50.0;
  const TrackSequence tracks = ReadTracks(table, options);
  EXPECT_THAT(tracks.header.skeleton.joints(), ElementsAre("nose", "l_hip"));
  ASSERT_EQ(tracks.frames.size(), 3u);
  EXPECT_EQ(tracks.frames[1].time, 20'000'000);
  const Pose3d& first = tracks.frames[0].people.at(0).joints;
  EXPECT_LT((first[0].position_m - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(),
            1e-15);
  EXPECT_FALSE(first[1].present());
  EXPECT_EQ(tracks.frames[1].people[0].joints[0].position_m.y(), -2.0);
  EXPECT_TRUE(tracks.frames[2].people.empty());

  std::vector<double> numbers(2 * 33 * 3);
  for (size_t i = 1; i < numbers.size(); ++i) numbers[i] = numbers[i - 1] + 1e3;
  const std::string array =
      folder.Write("mediapipe_skeleton_3d.npy", Npy("2, 33, 3", numbers));
  EXPECT_EQ(RecogniseKind(array), FileKind::kTracks);
  const TrackSequence again = ReadTracks(array);
  EXPECT_TRUE(again.header.skeleton == MediaPipe33());
  ASSERT_EQ(again.frames.size(), 2u);
  EXPECT_EQ(again.frames[1].people.at(0).joints[32].position_m,
            Eigen::Vector3d(195, 196, 197));
  testing::ExpectFaultsIn(
      "b.csv",
      {{"a_x,a_y,a_z\n1,2,three\n", "b.csv: line 2: found the text 'three'"}},
      [](const std::string& table_path) { ReadTracks(table_path); });
}

// ---- One network trained with two random seeds ----

constexpr const char* kHeader =
    "scorer,net,net,net,net,net,net\n"
    "bodyparts,nose,nose,nose,left_knee,left_knee,left_knee\n"
    "coords,x,y,likelihood,x,y,likelihood\n";

TEST(TwoDetectors, AreFusedJointByJoint) {
  const TemporaryFolder folder;
  const std::string header = kHeader;
  // Positions disagree if they are farther apart than 5 % of the diagonal of
  // the box around all joints: some 25 px for a box of some 300 x 400 px.
  folder.Write("seeds/rng0/cam1.csv", header + "0,100,100,0.9,400,500,0.4\n" +
                                          "1,100,100,0.9,400,500,0.8\n" +
                                          "2,100,100,0.9,,,\n");
  folder.Write("seeds/rng1/cam1.csv", header + "0,104,100,0.3,410,500,0.4\n" +
                                          "1,100,100,0.9,440,500,0.6\n" +
                                          "2,100,100,0.9,400,500,0.5\n");
  const std::string path = (folder.path() / "seeds").string();
  EXPECT_EQ(RecogniseKind(path), FileKind::kDetections);
  const DetectionSequence recording = ReadDetections(path);
  EXPECT_THAT(recording.header.view_names, ElementsAre("cam1"));
  ASSERT_EQ(recording.frames.size(), 3u);
  ASSERT_EQ(recording.frames[0].views[0].detections.size(), 1u);
  // Weighted by confidence: (0.9 * 100 + 0.3 * 104) / 1.2.
  EXPECT_NEAR(JointOf(recording, 0, 0, 0, 0).px.x(), 101.0, 1e-12);
  EXPECT_NEAR(JointOf(recording, 0, 0, 0, 0).confidence, 0.6, 1e-15);
  EXPECT_NEAR(JointOf(recording, 0, 0, 0, 1).px.x(), 405.0, 1e-12);
  // 40 px apart: the more confident position, from one of two detectors.
  EXPECT_EQ(JointOf(recording, 1, 0, 0, 1).px.x(), 400.0);
  EXPECT_NEAR(JointOf(recording, 1, 0, 0, 1).confidence, 0.4, 1e-15);
  // Found by a single detector.
  EXPECT_EQ(JointOf(recording, 2, 0, 0, 1).px.x(), 400.0);
  EXPECT_NEAR(JointOf(recording, 2, 0, 0, 1).confidence, 0.25, 1e-15);
}

TEST(TwoDetectors, MustHaveTheSameViews) {
  const TemporaryFolder folder;
  const std::string text = std::string(kHeader) + "0,1,1,1,2,2,1\n";
  folder.Write("seeds/rng0/cam1.csv", text);
  folder.Write("seeds/rng1/cam2.csv", text);
  ExpectInputError([&] { ReadDetections(folder.path() / "seeds"); },
                   "rng1: has other views than");
}

// ---- Folders of images beside the files of the views ----

TEST(ViewFiles, FoldersWithoutDataAreIgnored) {
  const TemporaryFolder folder;
  folder.Write("csv/plot-poses/cam1/filter.png", "");
  folder.Write("csv/cam1.csv",
               std::string(kHeader) + "0,100,200,1,300,400,1\n");
  std::string points = "[[100, 200]";
  std::string scores = "[1";
  std::string numbers = "[100, 200, 1";
  for (int j = 1; j < 17; ++j) {
    points += ", [300, 400]";
    scores += ", 1";
    numbers += ", 300, 400, 1";
  }
  folder.Write("coco/images/1.png", "");
  folder.Write("coco/cam1.json",
               R"([{"image_id": 0, "keypoints": )" + numbers + "]}]");
  folder.Write("mmpose/visualizations/1.png", "");
  folder.Write("mmpose/cam1.json",
               R"({"meta_info": {}, "instance_info": [{"frame_id": 0, )"
               R"("instances": [{"keypoints": )" +
                   points + R"(], "keypoint_scores": )" + scores + "]}]}]}");
  for (const std::string format : {"csv", "coco", "mmpose"}) {
    const DetectionSequence recording = ReadDetections(folder.path() / format);
    EXPECT_THAT(recording.header.view_names, ElementsAre("cam1")) << format;
    ASSERT_EQ(recording.frames.size(), 1u) << format;
    EXPECT_EQ(JointOf(recording, 0, 0, 0, 0).px.x(), 100.0) << format;
  }
}

// ---- Sessions of Caliscope and sleap-anipose ----

// Two cameras at 20 Hz, the second 4 ms late; camera 1 misses frame 7.
constexpr const char* kOld =
    "sync_index,port,frame_index,frame_time,point_id,img_loc_x,img_loc_y,"
    "obj_loc_x,obj_loc_y\n"
    "6,0,5,1000.000,0,100,200,,\n"
    "6,0,5,1000.000,11,110.5,210,,\n"
    "6,1,6,1000.004,0,300,400,,\n"
    "6,1,6,1000.004,105,1,1,,\n"
    "7,0,6,1000.050,0,101,201,,\n"
    "8,0,7,1000.100,0,102,202,,\n"
    "8,1,7,1000.104,0,0,0,,\n";

TEST(CaliscopeDetections, OldTablesAreRead) {
  const DetectionSequence recording = RecordingIn("xy_HOLISTIC.csv", kOld);
  EXPECT_THAT(recording.header.view_names, ElementsAre("cam_0", "cam_1"));
  EXPECT_EQ(recording.header.skeleton.name(), MediaPipe33().name());
  EXPECT_EQ(recording.header.frame_rate_hz, 20.0);
  ASSERT_EQ(recording.frames.size(), 3u);
  const DetectionFrame& first = recording.frames[0];
  EXPECT_EQ(first.frame, 6);
  ASSERT_EQ(first.views[0].detections.size(), 1u);
  EXPECT_EQ(JointOf(recording, 0, 0, 0, 11).px, Eigen::Vector2d(110.5, 210.0));
  EXPECT_FALSE(JointOf(recording, 0, 0, 0, 12).found);
  // Each camera has its own capture time, in ns; the frame's time is 6 / 20 Hz.
  // The double 1000.004 s is accurate to 1e-4 ns, TimeNs to 1 ns.
  EXPECT_EQ(first.time, 300'000'000);
  EXPECT_NEAR(static_cast<double>(first.views[1].capture_time -
                                  first.views[0].capture_time),
              4e6, 1.0);
  EXPECT_TRUE(recording.frames[1].views[1].detections.empty());
  EXPECT_EQ(CountFound(first.views[1].detections[0]), 1)
      << "the point of a hand is omitted";
}

TEST(CaliscopeDetections, NewTablesHaveTimesInTimestampsFile) {
  const TemporaryFolder folder;
  const std::string path = folder.Write(
      "xy_CHARUCO.csv",
      "sync_index,cam_id,object_id,keypoint_id,img_loc_x,img_loc_y,obj_loc_x,"
      "obj_loc_y,obj_loc_z\n"
      "35,2,0,4,10,20,0.1,0.1,0\n35,2,1,4,30,40,0.1,0.1,0\n"
      "36,2,0,7,11,21,0.1,0.1,0\n");
  folder.Write("timestamps.csv",
               "sync_index,cam_id,frame_index,frame_time\n35,2,0,25.0\n"
               "36,2,1,25.1\n35,3,0,25.0\n");
  const DetectionSequence recording = ReadDetections(path);
  EXPECT_THAT(recording.header.view_names, ElementsAre("cam_2"));
  EXPECT_THAT(recording.header.skeleton.joints(),
              ElementsAre("point_4", "point_7"));
  EXPECT_EQ(recording.header.frame_rate_hz, 10.0);
  ASSERT_EQ(recording.frames.size(), 2u);
  EXPECT_EQ(recording.frames[0].views[0].detections.size(), 2u)
      << "one detection per object_id";
}

TEST(CaliscopeDetections, ConfiguredRateHasPrecedence) {
  DetectionReadOptions options;
  options.frame_rate_hz = 50.0;
  const DetectionSequence recording = RecordingIn("xy_POSE.csv", kOld, options);
  EXPECT_EQ(recording.header.frame_rate_hz, 50.0);
  EXPECT_EQ(recording.frames[0].time, 120'000'000);
}

TEST(CaliscopeDetections, SessionWithASingleTableIsRead) {
  const TemporaryFolder folder;
  folder.Write("s/config.toml", "CreationDate = 2023-05-06\n");
  folder.Write("s/calibration/extrinsic/CHARUCO/xy_CHARUCO.csv", kOld);
  folder.Write("s/calibration/extrinsic/CHARUCO/xyz_CHARUCO.csv", "a\n");
  const std::string path = (folder.path() / "s").string();
  EXPECT_THAT(ReadDetections(path).header.skeleton.joints(),
              ElementsAre("point_0", "point_11", "point_105"));
  // Recordings of people have precedence over the board.
  folder.Write("s/recordings/walk/POSE/xy_POSE.csv", kOld);
  EXPECT_EQ(ReadDetections(path).header.skeleton.name(), MediaPipe33().name());
  folder.Write("s/recordings/run/POSE/xy_POSE.csv", kOld);
  const std::string error = InputErrorOf([&] { ReadDetections(path); });
  EXPECT_THAT(error, HasSubstr("recordings/run/POSE/xy_POSE.csv"));
  EXPECT_THAT(error, HasSubstr("recordings/walk/POSE/xy_POSE.csv"));
}

TEST(CaliscopeDetections, ViewsOfIgnoredCamerasAreOmitted) {
  const TemporaryFolder folder;
  folder.Write("s/xy_POSE.csv", kOld);
  const std::string path = (folder.path() / "s").string();
  const std::string pose = "rotation = [0.0, 0.0, 0.0]\n";
  folder.Write("s/config.toml", "[cam_0]\nport = 0\nignore = false\n" + pose +
                                    "[cam_1]\nport = 1\nignore = true\n" +
                                    pose);
  EXPECT_THAT(ReadDetections(path).header.view_names, ElementsAre("cam_0"));
  folder.Write("s/camera_array.toml",
               "[cameras.0]\nsize = [640, 480]\n[cameras.1]\n" + pose);
  EXPECT_THAT(ReadDetections(path).header.view_names, ElementsAre("cam_1"));
}

TEST(CaliscopeDetections, ErrorsNameTheFault) {
  const std::string good = kOld;
  ExpectFaults("xy_POSE.csv",
               {{good + "9,0,1,1000.2,0,abc,2,,\n",
                 "line 9: img_loc_x: found the text 'abc'"},
                {good + "9,0,1,1000.2,0.5,1,2,,\n", "point_id"},
                {good + "-9,0,1,1000.2,0,1,2,,\n", "sync_index"},
                {good + "9,0,1,1e300,0,1,2,,\n", "frame_time"},
                {good + "9,0,1\n", "found 3 cells"},
                {good.substr(0, good.find('\n') + 1), "has no points"}});
}

TEST(CaliscopeDetections, PublicSamplesAreRead) {
  KINEGRAPH_DATA_OR_SKIP(recordings, "takes");
  const DetectionSequence human =
      ReadDetections(recordings + "/caliscope_human");
  EXPECT_EQ(human.header.view_names.size(), 4u);
  EXPECT_EQ(human.header.skeleton.name(), MediaPipe33().name());
  EXPECT_NEAR(human.header.frame_rate_hz, 30.0, 0.5);
  EXPECT_EQ(human.frames.size(), 267u);
  const DetectionSequence board =
      ReadDetections(recordings + "/caliscope_board");
  EXPECT_EQ(board.header.skeleton.joint_count(), 12);
  EXPECT_EQ(board.frames.size(), 57u);
}

TEST(SleapSession, APublicSampleIsRead) {
  KINEGRAPH_DATA_OR_SKIP(path, "takes/mouse_sleap/minimal_session");
  const DetectionSequence recording = ReadDetections(path);
  EXPECT_THAT(recording.header.view_names,
              ElementsAre("back", "mid", "side", "top"));
  EXPECT_EQ(recording.frames.size(), 120u);
  EXPECT_EQ(recording.header.skeleton.joint_count(), 15);
}

}  // namespace
}  // namespace kinegraph
