#include "solvers/session/refine_take.h"

#include <gtest/gtest.h>

#include "apps/common/refinement.h"
#include "core/io/calibration.h"
#include "tests/support/faulty_scene.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::FaultyScene;
using testing::FaultySceneOptions;
using testing::MakeFaultyScene;

TEST(RefineTake, ARecordRepeatsTheDecision) {
  FaultySceneOptions scene_options;
  scene_options.seed = 21;
  scene_options.duration_s = 6.0;
  scene_options.clock_offset_s = {0.0, 0.05, 0.0, -0.04, 0.0};
  FaultyScene scene = MakeFaultyScene(scene_options);
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    scene.cameras[v] = testing::Turned(scene.cameras[v], 0.5, 400 + v);
  }
  RunOptions options;
  options.refine.refine = RefineKind::kRotation;
  options.refine.refine_clock = true;
  RunRequest request;
  request.cameras = scene.cameras;
  const RefinedTake refined = RefineTake(options, request, scene.detections);
  ASSERT_TRUE(refined.record.has_clocks());
  // The cameras turned back, to a fifth of what was put in at most.
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    EXPECT_LT(testing::AngleBetween(refined.cameras[v], scene.scene.cameras[v]),
              0.1);
  }
  // Through the file, as a later run reads it: the same bits.
  const testing::TemporaryFolder folder;
  const std::string path = folder.path().string() + "/take.cameras.json";
  WriteCameras(path, refined.cameras, RefinementJson(refined));
  const auto record = ReadRefinementRecord(path);
  ASSERT_TRUE(record.has_value());
  RunRequest later;
  later.cameras = ReadCameras(path);
  const DetectionSequence clocked =
      WithRecordedClocks(RunOptions(), later, *record, scene.detections);
  ASSERT_EQ(clocked.frames.size(), refined.detections.frames.size());
  for (size_t k = 0; k < clocked.frames.size(); ++k) {
    for (size_t v = 0; v < 5; ++v) {
      const ViewDetections& one = clocked.frames[k].views[v];
      const ViewDetections& other = refined.detections.frames[k].views[v];
      EXPECT_EQ(one.capture_time, other.capture_time);
      EXPECT_EQ(one.detections.size(), other.detections.size());
    }
  }
  for (size_t v = 0; v < 5; ++v) {
    EXPECT_EQ(later.cameras[v].R(), refined.cameras[v].R());
    EXPECT_EQ(later.cameras[v].t(), refined.cameras[v].t());
  }
}

TEST(RefineTake, OtherCalibrationsHaveNoRecord) {
  const testing::TemporaryFolder folder;
  EXPECT_FALSE(ReadRefinementRecord(folder.path().string()).has_value());
  EXPECT_FALSE(
      ReadRefinementRecord(folder.Write("a.json", "{\"0\": {}}")).has_value());
  EXPECT_FALSE(
      ReadRefinementRecord(folder.Write("b.json", "{\"kinegraph_cameras\": 1}"))
          .has_value());
}

}  // namespace
}  // namespace kinegraph
