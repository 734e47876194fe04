// BVH of other programs, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/io/tracks/tracks.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

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

TEST(TracksBvh, OtherProgramsChannelsAndNames) {
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
  // The place takes the offset's place.
  EXPECT_LT((at(0, 0) - Vector3d(0.0, 1.0, 0.0)).norm(), 1e-12);
  // Turned about Y by 90 degrees, X points to -Z.
  EXPECT_LT((at(0, 1) - Vector3d(0.0, 1.0, -0.1)).norm(), 1e-12);
  EXPECT_LT((at(0, 2) - Vector3d(0.0, 0.6, -0.1)).norm(), 1e-12);
  // The thigh turned about Z by 90 degrees: -Y becomes X.
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

// A rounded time means a whole rate; that of NTSC is a thousandth below.
TEST(TracksBvh, RatesOfRoundedTimes) {
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
  EXPECT_NEAR(rate_of("0.03336666666666667"), 30000.0 / 1001.0, 1e-9);
  EXPECT_NEAR(rate_of("0.016683333333333335"), 60000.0 / 1001.0, 1e-9);
}

}  // namespace
}  // namespace kinegraph
