// Reads the examples of docs/formats.md. Files that `track` and `doctor` write
// for scripts are compared in tests/apps/docs.
#include <gtest/gtest.h>

#include <string>

#include "core/io/calibration/calibration.h"
#include "core/io/configuration/recording_files.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/detections/source.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/identity_edits.h"
#include "core/io/tracks/tracks.h"
#include "tests/support/page_example.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;
using testing::PageExample;
using testing::TemporaryFolder;

class FormatsPage : public ::testing::Test {
 protected:
  std::string Example(const std::string& name) const {
    return folder_.Write(name, PageExample("docs/formats.md", name));
  }
  const TemporaryFolder folder_;
};

TEST_F(FormatsPage, Cameras) {
  const std::string path = Example("cameras.json");
  const CameraRig cameras = ReadCameras(path);
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].name(), "left");
  EXPECT_EQ(cameras[0].width_px(), 1920);
  ASSERT_NE(cameras[0].lens(), nullptr);
  EXPECT_EQ(cameras[0].lens()->model(), "opencv5");
  // The point (0.3, 0, 0) is 4 m in front of the camera, 0.3 m to its right and
  // 1.5 m below it.
  EXPECT_LT((cameras[0].R() * Vector3d(0.3, 0.0, 0.0) + cameras[0].t() -
             Vector3d(0.3, 1.5, 4.0))
                .norm(),
            1e-12);
  EXPECT_EQ(cameras[1].width_px(), 0) << "not known";
  EXPECT_EQ(cameras[1].lens(), nullptr);
  const auto record = ReadRefinementRecord(path);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->cameras[1].offset_s, 0.012);
  EXPECT_EQ(record->covariance(0, 0), 1e-6);
}

TEST_F(FormatsPage, Detections) {
  const DetectionSequence recording =
      ReadDetections(Example("detections.jsonl"));
  EXPECT_EQ(recording.header.frame_rate_hz, 50.0);
  EXPECT_EQ(recording.header.view_names,
            (std::vector<std::string>{"left", "right"}));
  ASSERT_EQ(recording.frames.size(), 2u);
  const DetectionFrame& first = recording.frames[0];
  EXPECT_EQ(first.frame, 300);
  EXPECT_EQ(first.time, 6'000'000'000);
  EXPECT_EQ(first.views[1].capture_time, 6'012'000'000);
  ASSERT_EQ(first.views[0].detections.size(), 1u);
  EXPECT_TRUE(first.views[0].detections[0].joints[0].found);
  EXPECT_FALSE(first.views[0].detections[0].joints[1].found);
  EXPECT_EQ(recording.frames[1].time, 6'040'000'000) << "frame / frame_rate";
  EXPECT_TRUE(recording.frames[1].views[0].detections.empty());
}

TEST_F(FormatsPage, Tracks) {
  const std::string path = Example("tracks.jsonl");
  const TrackSequence tracks = ReadTracks(path);
  ASSERT_EQ(tracks.frames.size(), 2u);
  EXPECT_EQ(tracks.frames[1].time, 6'040'000'000) << "frame / frame_rate";
  const PersonPose& person = tracks.frames[0].people[0];
  EXPECT_EQ(person.joints[0].position_m, Vector3d(0.1, 0.2, 1.3));
  EXPECT_EQ(person.joints[1].status, JointStatus::kMissing);
  EXPECT_EQ((*person.covariances[0])(2, 2), 4e-4);
  ASSERT_EQ(person.matches.size(), 2u);
  EXPECT_EQ(person.matches[1].weights[0], 0.5);
  EXPECT_EQ(ReadPersonNames(path), (PersonNames{{TrackId(3), "Anna"}}));
}

TEST_F(FormatsPage, Corrections) {
  const std::vector<IdentityEdit> edits =
      ReadIdentityEdits(Example("take.identity.jsonl"));
  ASSERT_EQ(edits.size(), 3u);
  EXPECT_EQ(edits[0].op, EditOp::kJoin);
  EXPECT_EQ(edits[0].margin, 8.4);
  EXPECT_EQ(edits[1].frames->last, 425);
  EXPECT_EQ(edits[2].name, "Anna");
}

TEST_F(FormatsPage, HeldOutSet) {
  const HeldOutSet set =
      ReadHeldOutSet(Example("held_out_set.json"), {"left", "cam_2"});
  EXPECT_EQ(set.cap_px, 100.0);
  ASSERT_EQ(set.detections.size(), 2u);
  EXPECT_EQ(set.detections[1].view_name, "cam_2");
  EXPECT_EQ(set.detections[1].person, TrackId(4));
}

TEST_F(FormatsPage, Bias) {
  const ViewBias bias = ReadViewBias(Example("take.bias.json"));
  EXPECT_EQ(bias.azimuth_deg, 140.5);
  ASSERT_EQ(bias.joints.size(), 1u);
  EXPECT_TRUE(bias.joints[0].used);
  EXPECT_EQ(bias.joints[0].along_m[1], 0.02);
}

}  // namespace
}  // namespace kinegraph
