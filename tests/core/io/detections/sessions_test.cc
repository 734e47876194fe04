#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "tests/core/io/detections/detection_files.h"
#include "tests/support/hdf5_files.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using testing::FaultOf;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::RecordingIn;
using testing::TemporaryFolder;

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
  const auto& joints = first.views[0].detections[0].joints;
  EXPECT_EQ(joints[11].px, Eigen::Vector2d(110.5, 210.0));
  EXPECT_FALSE(joints[12].found);
  // Each camera's own time; the frame's is between them, where 6 / 20 Hz is.
  EXPECT_EQ(first.time, 300'000'000);
  EXPECT_NEAR(static_cast<double>(first.views[1].capture_time -
                                  first.views[0].capture_time),
              4e6, 1.0);
  EXPECT_TRUE(recording.frames[1].views[1].detections.empty());
  EXPECT_EQ(CountFound(first.views[1].detections[0]), 1) << "a hand's is left";
}

TEST(CaliscopeDetections, NewTablesHaveTheirTimesBeside) {
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
  EXPECT_EQ(recording.frames[0].views[0].detections.size(), 2u) << "objects";
}

TEST(CaliscopeDetections, AGivenRateWins) {
  DetectionReadOptions options;
  options.frame_rate_hz = 50.0;
  const DetectionSequence recording = RecordingIn("xy_POSE.csv", kOld, options);
  EXPECT_EQ(recording.header.frame_rate_hz, 50.0);
  EXPECT_EQ(recording.frames[0].time, 120'000'000);
}

TEST(CaliscopeDetections, ASessionIsReadByTheOneTableInIt) {
  const TemporaryFolder folder;
  folder.Write("s/config.toml", "CreationDate = 2023-05-06\n");
  folder.Write("s/calibration/extrinsic/CHARUCO/xy_CHARUCO.csv", kOld);
  folder.Write("s/calibration/extrinsic/CHARUCO/xyz_CHARUCO.csv", "a\n");
  const std::string path = (folder.path() / "s").string();
  EXPECT_THAT(ReadDetections(path).header.skeleton.joints(),
              ElementsAre("point_0", "point_11", "point_105"));
  // Recordings of people come before the board.
  folder.Write("s/recordings/walk/POSE/xy_POSE.csv", kOld);
  EXPECT_EQ(ReadDetections(path).header.skeleton.name(), MediaPipe33().name());
  folder.Write("s/recordings/run/POSE/xy_POSE.csv", kOld);
  const std::string error = InputErrorOf([&] { ReadDetections(path); });
  EXPECT_THAT(error, HasSubstr("recordings/run/POSE/xy_POSE.csv"));
  EXPECT_THAT(error, HasSubstr("recordings/walk/POSE/xy_POSE.csv"));
}

TEST(CaliscopeDetections, ViewsOfIgnoredCamerasAreLeftOut) {
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

TEST(CaliscopeDetections, FaultsAreNamed) {
  const TemporaryFolder folder;
  const auto fault = [&](const std::string& row) {
    return FaultOf("xy_POSE.csv", kOld + row);
  };
  EXPECT_THAT(fault("9,0,1,1000.2,0,abc,2,,\n"),
              HasSubstr("line 9: img_loc_x: found the text 'abc'"));
  EXPECT_THAT(fault("9,0,1,1000.2,0.5,1,2,,\n"), HasSubstr("point_id"));
  EXPECT_THAT(fault("-9,0,1,1000.2,0,1,2,,\n"), HasSubstr("sync_index"));
  EXPECT_THAT(fault("9,0,1,1e300,0,1,2,,\n"), HasSubstr("frame_time"));
  EXPECT_THAT(fault("9,0,1\n"), HasSubstr("found 3 cells"));
  const std::string head = kOld;
  const std::string empty =
      folder.Write("xy.csv", head.substr(0, head.find('\n') + 1));
  EXPECT_THAT(InputErrorOf([&] { ReadDetections(empty); }),
              HasSubstr("has no points"));
}

TEST(CaliscopeDetections, SamplesOfOthersAreRead) {
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

// sleap-anipose's: a folder a camera, other HDF5 beside them.
TEST(SleapSession, IsAFolderACamera) {
  const TemporaryFolder folder;
  const std::string bytes = testing::SleapHdf5();
  folder.Write("s/calibration.toml", "[metadata]\n");
  folder.Write("s/points3d.h5", "\x89HDF of another program");
  for (const char* camera : {"top", "back", "mid"}) {
    folder.Write("s/" + std::string(camera) + "/minimal.analysis.h5", bytes);
    folder.Write("s/" + std::string(camera) + "/other.h5", "no HDF5");
  }
  const std::string path = (folder.path() / "s").string();
  const DetectionSequence recording = ReadDetections(path);
  EXPECT_THAT(recording.header.view_names, ElementsAre("back", "mid", "top"));
  ASSERT_EQ(recording.frames.size(), 3u);
  EXPECT_EQ(recording.frames[0].views[2].detections.size(), 1u);
  folder.Write("s/mid/second.analysis.h5", bytes);
  EXPECT_THAT(InputErrorOf([&] { ReadDetections(path); }),
              HasSubstr("mid: holds 2 analyses"));
}

TEST(SleapSession, ASampleOfOthersIsRead) {
  KINEGRAPH_DATA_OR_SKIP(path, "takes/mouse_sleap/minimal_session");
  const DetectionSequence recording = ReadDetections(path);
  EXPECT_THAT(recording.header.view_names,
              ElementsAre("back", "mid", "side", "top"));
  EXPECT_EQ(recording.frames.size(), 120u);
  EXPECT_EQ(recording.header.skeleton.joint_count(), 15);
}

}  // namespace
}  // namespace kinegraph
