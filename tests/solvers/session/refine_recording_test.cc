#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "apps/common/recording_output.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/evaluation/mpjpe.h"
#include "core/io/calibration/calibration.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/run.h"
#include "tests/support/faulty_scene.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::FaultyScene;
using testing::FaultySceneOptions;
using testing::MakeFaultyScene;

RunOptions OptionsWith(const std::string& keys) {
  return ParseRunOptions(
      "mode = \"graph\"\n[gates]\nunits = \"metres\"\n[output]\n"
      "estimator = \"batch\"\n",
      keys, "");
}

const char* const kBoth = "cameras.refine=rotation;cameras.refine_clock=true";

// Every camera is rotated by half a degree, and two clocks are wrong.
FaultyScene TurnedScene() {
  FaultySceneOptions options = {21, 5, 4, 6.0};
  options.clock_offset_s = {0.0, 0.05, 0.0, -0.04, 0.0};
  FaultyScene scene = MakeFaultyScene(options);
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    scene.cameras[v] = testing::Turned(scene.cameras[v], 0.5, 400 + v);
  }
  return scene;
}

ReadyRecording Ready(const FaultyScene& scene, const std::string& keys) {
  RunRequest request;
  request.cameras = scene.cameras;
  return MakeRecordingReady(OptionsWith(keys), request, std::nullopt,
                            [&] { return scene.detections; });
}

TEST(RefineRecording, ARecordReproducesTheRefinement) {
  const FaultyScene scene = TurnedScene();
  const ReadyRecording refined =
      Ready(scene, std::string(kBoth) + ";cameras.ground=feet");
  ASSERT_TRUE(refined.record->has_clocks());
  ASSERT_TRUE(refined.ground.has_value());
  ASSERT_GT(refined.record->covariance.rows(), 0);
  // At most a fifth of the inserted half degree remains. The true cameras are
  // moved to the same floor.
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    const CameraRig truth = OnGround(scene.scene.cameras, *refined.ground);
    EXPECT_LT(testing::AngleBetween(refined.cameras[v], truth[v]), 0.1);
  }
  // Written to a file and read by a later run, the record gives bitwise the
  // same result.
  const testing::TemporaryFolder folder;
  const std::string path = folder.path().string() + "/recording.cameras.json";
  WriteCameras(path, refined.cameras, RefinementJson(refined));
  const auto record = ReadRefinementRecord(path);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->covariance, refined.record->covariance);
  RunRequest later;
  later.cameras = ReadCameras(path);
  const ReadyRecording again = MakeRecordingReady(
      OptionsWith(""), later, record, [&] { return scene.detections; });
  ASSERT_EQ(again.detections->frames.size(), refined.detections->frames.size());
  for (size_t k = 0; k < again.detections->frames.size(); ++k) {
    for (size_t v = 0; v < 5; ++v) {
      const ViewDetections& one = again.detections->frames[k].views[v];
      const ViewDetections& other = refined.detections->frames[k].views[v];
      EXPECT_EQ(one.capture_time, other.capture_time);
      EXPECT_EQ(one.detections.size(), other.detections.size());
    }
  }
  for (size_t v = 0; v < 5; ++v) {
    EXPECT_EQ(record->cameras[v].places, refined.record->cameras[v].places);
    EXPECT_EQ(later.cameras[v].R(), refined.cameras[v].R());
    EXPECT_EQ(later.cameras[v].t(), refined.cameras[v].t());
  }
  // A refined recording is not refined again.
  EXPECT_THROW(MakeRecordingReady(OptionsWith(kBoth), later, record,
                                  [&] { return scene.detections; }),
               OptionError);
}

TEST(RefineRecording, RefinedCamerasReduceErrorsAndCoverThem) {
  const FaultyScene scene = TurnedScene();
  const TrackSequence truth = TruthOf(scene.scene);
  RunRequest request;
  request.cameras = scene.cameras;
  const TrackSequence stated =
      TrackSequenceOf(OptionsWith(""), request, scene.detections);
  const TrackSequence refined =
      TrackSequenceOf(OptionsWith(kBoth), request, scene.detections);
  // Half a degree is 6 cm at 6.5 m, half of which remains with five cameras.
  // Refinement removes nine tenths of this, but not the detector's noise.
  EXPECT_LT(EvaluateMpjpe(truth, refined).raw_m,
            0.6 * EvaluateMpjpe(truth, stated).raw_m);
  // The uncertainty of the cameras enlarges the covariances, which then cover
  // more of the errors.
  const ReadyRecording ready = Ready(scene, kBoth);
  RunRequest asked;
  asked.cameras = ready.cameras;
  const TrackSequence alone =
      TrackSequenceOf(OptionsWith(""), asked, *ready.detections);
  ASSERT_EQ(EvaluateMpjpe(truth, alone).raw_m,
            EvaluateMpjpe(truth, refined).raw_m);
  EXPECT_LT(EvaluateConsistency(truth, refined).all.nees_per_dof,
            EvaluateConsistency(truth, alone).all.nees_per_dof);
  // Matches were used internally but not requested.
  for (const TrackFrame& frame : refined.frames) {
    for (const PersonPose& person : frame.people) {
      EXPECT_TRUE(person.matches.empty());
    }
  }
}

// People who mostly stand give little information on clock offsets, which
// reduces the gain of the fit per observation.
TEST(RefineRecording, ClocksAreFoundIfPeopleHopAndStop) {
  KINEGRAPH_DATA_OR_SKIP(clip, "motion/start_hop_stop_120hz.jsonl");
  FaultySceneOptions options = {7301, 5, 4, 10.0};
  options.clips.assign(4, clip);
  options.clip_start_s = {0.0, 0.37, 0.74, 1.11};
  options.clock_offset_s = {0.0, 0.08, 0.0, -0.05, 0.0};
  const FaultyScene scene = MakeFaultyScene(options);
  RunRequest request;
  request.cameras = scene.cameras;
  const ReadyRecording refined = RefineRecording(
      OptionsWith("cameras.refine_clock=true;tracking.feedback=gaussian"),
      request, scene.detections);
  for (size_t v = 0; v < 5; ++v) {
    // Four times the error of 0.4 ms in eight other recordings
    // (refine_accuracy).
    EXPECT_NEAR(refined.record->cameras[v].offset_s, options.clock_offset_s[v],
                0.0016);
  }
}

// At 4 Hz, motion segments of the usual fifth of a second have one frame.
TEST(RefineRecording, ClocksAreFoundAtLowFrameRates) {
  FaultySceneOptions options = {22, 5, 4, 20.0};
  options.frame_rate_hz = 4.0;
  options.clock_offset_s = {0.0, 0.0, 0.5, 0.0, 0.0};
  const ReadyRecording refined =
      Ready(MakeFaultyScene(options), "cameras.refine_clock=true");
  EXPECT_FALSE(refined.refinement->hardly_moves);
  // An eighth of a frame.
  for (size_t v = 0; v < 5; ++v) {
    EXPECT_NEAR(refined.record->cameras[v].offset_s, options.clock_offset_s[v],
                0.03);
  }
}

// A detector ran on every fifth frame: three recorded frames are 0.6 s. The
// tolerance is less than a sixth of a recorded frame.
TEST(RefineRecording, ClocksAreFoundInEveryFifthFrame) {
  FaultySceneOptions options = {24, 5, 4, 30.0};
  options.clock_offset_s = {0.0, 0.0, 0.6, 0.0, 0.0};
  FaultyScene scene = MakeFaultyScene(options);
  std::vector<DetectionFrame>& frames = scene.detections.frames;
  frames.erase(std::remove_if(frames.begin(), frames.end(),
                              [](const DetectionFrame& one) {
                                return one.frame % 5 != 0;
                              }),
               frames.end());
  const ReadyRecording refined = Ready(scene, "cameras.refine_clock=true");
  for (size_t v = 0; v < 5; ++v) {
    EXPECT_NEAR(refined.record->cameras[v].offset_s, options.clock_offset_s[v],
                0.03);
  }
  // The lag is in frame numbers, five per recorded frame, and may be wrong by
  // one recorded frame.
  EXPECT_NEAR(static_cast<double>(refined.refinement->lag_numbers.at(2)), -15.0,
              5.0);
}

// A quarter of the frames is missing. The tolerance is a quarter of a frame.
TEST(RefineRecording, ClocksAreFoundIfFramesAreMissing) {
  FaultySceneOptions options = {25, 5, 4, 16.0};
  options.clock_offset_s = {0.0, 0.0, 0.6, 0.0, 0.0};
  FaultyScene scene = MakeFaultyScene(options);
  std::vector<DetectionFrame>& frames = scene.detections.frames;
  Random random(1);
  frames.erase(std::remove_if(frames.begin(), frames.end(),
                              [&](const DetectionFrame&) {
                                return random.Uniform(0.0, 1.0) < 0.25;
                              }),
               frames.end());
  const ReadyRecording refined = Ready(scene, "cameras.refine_clock=true");
  for (size_t v = 0; v < 5; ++v) {
    EXPECT_NEAR(refined.record->cameras[v].offset_s, options.clock_offset_s[v],
                0.01);
  }
}

// A record without clocks, as `calibrate --in_step` writes it, remains if a
// refinement is rejected or changes only clocks.
TEST(RefineRecording, UnchangedCamerasKeepTheirRecordedUncertainty) {
  RefinementRecord recorded;
  FaultySceneOptions options = {23, 5, 4, 6.0};
  const FaultyScene scene = MakeFaultyScene(options);
  for (const Camera& camera : scene.cameras) {
    recorded.cameras.push_back(
        {camera.name(),
         0.0,
         0.0,
         {kRotationAt, kCentreAt, kCentreAt + 1, kCentreAt + 2}});
  }
  recorded.covariance = Eigen::MatrixXd::Constant(20, 20, 1e-7);
  for (int i = 0; i < 20; ++i) recorded.covariance(i, i) += 1e-6 * (i + 1);
  const auto ready = [&](const FaultyScene& of, const std::string& keys) {
    RunRequest request;
    request.cameras = of.cameras;
    return MakeRecordingReady(OptionsWith(keys), request, recorded,
                              [&] { return of.detections; });
  };
  const ReadyRecording rejected = ready(scene, "cameras.refine=shift");
  ASSERT_FALSE(rejected.refinement->any_taken());
  EXPECT_EQ(rejected.record->covariance, recorded.covariance);
  options.clock_offset_s = {0.0, 0.06, 0.0, -0.06, 0.0};
  const ReadyRecording clocks =
      ready(MakeFaultyScene(options), "cameras.refine_clock=true");
  ASSERT_TRUE(clocks.refinement->any_taken());
  Eigen::Index at = 0;
  for (size_t v = 0; v < recorded.cameras.size(); ++v) {
    const std::vector<int>& places = clocks.record->cameras[v].places;
    const auto centre = std::find(places.begin(), places.end(), kCentreAt);
    ASSERT_NE(centre, places.end());
    const Eigen::Index row = at + (centre - places.begin());
    const auto before = static_cast<Eigen::Index>(4 * v + 1);
    EXPECT_EQ(clocks.record->covariance(row, row),
              recorded.covariance(before, before));
    at += static_cast<Eigen::Index>(places.size());
  }
  EXPECT_EQ(clocks.record->covariance.rows(), at);
  EXPECT_GT(at, 20);  // with the clocks
}

TEST(RefineRecording, OtherCalibrationsHaveNoRecord) {
  const testing::TemporaryFolder folder;
  EXPECT_FALSE(ReadRefinementRecord(folder.path().string()).has_value());
  EXPECT_FALSE(
      ReadRefinementRecord(folder.Write("a.json", "{\"0\": {}}")).has_value());
  EXPECT_FALSE(
      ReadRefinementRecord(folder.Write("b.json", "{\"kinegraph_cameras\": 1}"))
          .has_value());
}

TEST(RefineRecording, BrokenRecordsAreRefused) {
  const testing::TemporaryFolder folder;
  const auto read = [&](const std::string& camera, const std::string& rest) {
    return ReadRefinementRecord(folder.Write(
        "a.json",
        R"({"kinegraph_cameras": 1, "refinement": {"cameras": [{"name": "a", )" +
            camera + "}]" + rest + "}}"));
  };
  const std::string two =
      R"("parameters": ["rotation_x_rad", "rotation_y_rad"])";
  const auto good = read(two, R"(, "covariance": [[1, 0.5], [0.5, 1]])");
  ASSERT_TRUE(good.has_value());
  EXPECT_EQ(good->covariance(0, 1), 0.5);
  EXPECT_THROW(read(two, ""), InputError);  // no covariance
  EXPECT_THROW(read(two, R"(, "covariance": [[1]])"), InputError);
  EXPECT_THROW(read(two, R"(, "covariance": [[1, 0.5], [0, 1]])"), InputError);
  EXPECT_THROW(read(two, R"(, "covariance": [[-1, 0], [0, 1]])"), InputError);
  EXPECT_THROW(read(R"("parameters": ["x"])", R"(, "covariance": [[1]])"),
               InputError);
  EXPECT_THROW(read(R"("parameters": ["shift_x_px", "rotation_x_rad"])",
                    R"(, "covariance": [[1, 0], [0, 1]])"),
               InputError);
}

}  // namespace
}  // namespace kinegraph
