#include "core/io/configuration/held_out_set.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "core/base/error.h"
#include "core/io/detections/source.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

TEST(ReadHeldOutSet, ScoresTheJointsThatTheReadmeCounts) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/reference/held_out_set.json");
  KINEGRAPH_DATA_OR_SKIP(detections, "shelf/detections/openpose");
  const DetectionSequence recording = ReadDetections(detections);
  const HeldOutSet set = ReadHeldOutSet(path, recording.header.view_names);
  EXPECT_EQ(set.min_confidence, 0.3);
  EXPECT_EQ(set.cap_px, 100.0);
  EXPECT_EQ(set.pairing_gate_m, 0.5);
  ASSERT_EQ(set.detections.size(), 3642u);
  EXPECT_EQ(set.detections.back().view_name, "cam4");
  EXPECT_EQ(set.detections.back().frame, 600);
  EXPECT_EQ(set.detections.back().detection_idx, 1);
  EXPECT_EQ(set.detections.back().person, TrackId(2));
  // "49,594 joints with confidence >= 0.3", of the joints of COCO-17.
  const std::vector<int> map = MapByName(Body25(), Coco17());
  std::map<std::string, size_t> view_of;
  for (size_t v = 0; v < recording.header.view_names.size(); ++v) {
    view_of[recording.header.view_names[v]] = v;
  }
  int joints = 0;
  for (const HeldOutDetection& entry : set.detections) {
    const DetectionFrame& frame =
        recording.frames[static_cast<size_t>(entry.frame - 300)];
    const Detection& detection = frame.views[view_of.at(entry.view_name)]
                                     .detections[entry.detection_idx];
    for (const int j : map) {
      const Keypoint& joint = detection.joints[j];
      joints += joint.found && joint.confidence >= set.min_confidence ? 1 : 0;
    }
  }
  EXPECT_EQ(joints, 49594);
}

TEST(ReadHeldOutSet, CamerasBecomeViews) {
  const testing::TemporaryFolder folder;
  const auto write = [&](const std::string& camera) {
    return folder.Write("set.json",
                        R"({"confidence_at_least": 0.3, "cap_px": 100, )"
                        R"("pairing_gate_m": 0.5, "set": [{"camera": )" +
                            camera +
                            R"(, "frame": 1, "detection": 0, "person": 0}]})");
  };
  const auto view = [&](const std::string& camera,
                        const std::vector<std::string>& views) {
    return ReadHeldOutSet(write(camera), views).detections[0].view_name;
  };
  EXPECT_EQ(view("4", {}), "4");
  EXPECT_EQ(view("\"left\"", {}), "left");
  EXPECT_EQ(view("4", {"cam4", "cam14"}), "cam4");
  EXPECT_EQ(view("4", {"cam04", "4"}), "4");
  EXPECT_EQ(view("\"left\"", {"right", "left"}), "left");
  EXPECT_THROW(view("4", {"cam04", "cam4"}), InputError);
  EXPECT_THROW(view("5", {"cam4"}), InputError);
  EXPECT_THROW(view("\"left\"", {"right"}), InputError);
  EXPECT_THROW(view("-1", {}), InputError);
  EXPECT_THROW(view("null", {}), InputError);
}

}  // namespace
}  // namespace kinegraph
