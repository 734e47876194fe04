// Tests views of different frame rates in one recording
// (input.view_frame_rate), from files to tracks.
#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"
#include "core/data/limits.h"
#include "core/evaluation/mpjpe.h"
#include "core/io/detections/format.h"
#include "solvers/session/run.h"
#include "tests/support/faulty_scene.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::FaultyScene;
using testing::FaultySceneOptions;

// Five views of a scene at 50 Hz: three are recorded at 25 Hz, the last two at
// 10 Hz. The files of each view count from zero.
FaultyScene SceneAt50Hz() {
  FaultySceneOptions options = {41, 5, 3, 4.0};
  options.frame_rate_hz = 50.0;
  return testing::MakeFaultyScene(options);
}

constexpr size_t kStride[] = {2, 2, 2, 5, 5};  // by view, in frames of 50 Hz

// Writes the views' detections as OpenPose folders; returns their path.
std::string WriteFolders(const FaultyScene& scene,
                         const testing::TemporaryFolder& folder) {
  DetectionSequence counted;
  counted.header = scene.detections.header;
  counted.header.frame_rate_hz = 25.0;
  const size_t count = scene.detections.frames.size();
  for (size_t n = 0; 2 * n < count; ++n) {
    DetectionFrame& frame = counted.frames.emplace_back();
    frame.frame = static_cast<int64_t>(n);
    frame.time = FrameClock(25.0).TimeOf(frame.frame);
    frame.views.resize(5);
    for (size_t v = 0; v < 5; ++v) {
      frame.views[v].capture_time = frame.time;
      if (n * kStride[v] >= count) continue;
      frame.views[v].detections =
          scene.detections.frames[n * kStride[v]].views[v].detections;
    }
  }
  const std::string path = (folder.path() / "openpose").string();
  MemorySource source(counted);
  LostFields lost_fields;
  FindDetectionFormat("openpose")->write(path, {}, &source, &lost_fields);
  return path;
}

RunOptions OptionsAt25HzWith(const std::string& keys) {
  return ParseRunOptions(
      "mode = \"graph\"\n[gates]\nunits = \"metres\"\n[output]\n"
      "estimator = \"batch\"\n[input]\nframe_rate = 25\n",
      keys, "");
}

// Mean distance of the tracks from the truth [m].
double ErrorOf(const FaultyScene& scene, const RunOptions& options,
               const std::string& path,
               const std::vector<std::string>& without = {}) {
  RunRequest request;
  request.cameras = scene.cameras;
  request.without_cameras = without;
  TrackSequence truth = TruthOf(scene.scene);
  // Every second frame of the truth is one of the recording.
  TrackSequence of_recording = truth;
  of_recording.frames.clear();
  for (size_t k = 0; k < truth.frames.size(); k += 2) {
    of_recording.frames.push_back(truth.frames[k]);
    of_recording.frames.back().frame = static_cast<int64_t>(k / 2);
  }
  const DetectionSequence read =
      ReadDetections(path, DetectionOptionsOf(options));
  return EvaluateMpjpe(of_recording, TrackSequenceOf(options, request, read))
      .raw_m;
}

TEST(ViewRates, SlowerViewsReduceTheError) {
  const FaultyScene scene = SceneAt50Hz();
  const testing::TemporaryFolder folder;
  const std::string path = WriteFolders(scene, folder);
  const auto& names = scene.detections.header.view_names;
  const RunOptions rated =
      OptionsAt25HzWith("input.view_frame_rate." + names[3] +
                        "=10;input.view_frame_rate." + names[4] + "=10");
  const double rated_m = ErrorOf(scene, rated, path);
  // Two more views in two of five frames, some captured 20 ms from the frame's
  // time, add measurements and reduce the error.
  EXPECT_LT(rated_m, ErrorOf(scene, rated, path, {names[3], names[4]}));
  // If the two views are read at the recording's rate, they show other
  // instants.
  EXPECT_LT(rated_m, 0.8 * ErrorOf(scene, OptionsAt25HzWith(""), path));
}

TEST(ViewRates, ValidRatesAreReadAndOthersRejected) {
  for (const std::string value : {"x", "0", "-1", "1.1e6", "nan", "25Hz"}) {
    const RunOptions options =
        OptionsAt25HzWith("input.view_frame_rate.a=" + value);
    EXPECT_THROW(DetectionOptionsOf(options), OptionError) << value;
  }
  const RunOptions table = ParseRunOptions(
      "[input.view_frame_rate]\na = 50\nb = 29.97\nc = \"12.5\"\nd = 1e6\n", "",
      "");
  const DetectionReadOptions read = DetectionOptionsOf(table);
  EXPECT_EQ(read.view_frame_rate_hz.at("a"), 50.0);
  EXPECT_EQ(read.view_frame_rate_hz.at("b"), 29.97);
  EXPECT_EQ(read.view_frame_rate_hz.at("c"), 12.5);
  EXPECT_EQ(read.view_frame_rate_hz.at("d"), kMaxFrameRate_hz);
}

}  // namespace
}  // namespace kinegraph
