// Synthetic detections are tracked by the whole front end and compared with the
// scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/evaluation/correspondence.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "core/tracking/tracker.h"
#include "solvers/factory.h"

namespace kinegraph {
namespace {

// People stay where every camera sees all of them, so that no joint is
// triangulated with a view of an earlier frame.
Scene SmallScene(std::vector<double> distortion) {
  SceneOptions options;
  options.seed = 23;
  options.people = 3;
  options.duration_s = 8.0;
  options.skeleton = "body25";
  options.motion.area_radius_m = 1.6;
  options.motion.visitors = 0.0;
  options.cameras.count = 5;
  options.cameras.distortion = std::move(distortion);
  return MakeScene(options);
}

// The plain triangulation: no smoothing, no view removed.
struct PlainOptions {
  EstimatorOptions estimators;
  TrackerOptions tracker;

  PlainOptions() {
    estimators.mode = Mode::kPaper;
    estimators.gaussian.smooth = false;
    tracker.reconstruction.joints_filter = false;
    tracker.initialisation.alpha_filter_px = 1e6;
    // People are followed from the last pose: 3 m/s at 4 m depth are 24 px per
    // frame.
    tracker.association.alpha_2d_px_per_frame = 100.0;
  }
};

std::vector<TrackFrame> TrackAll(const Scene& scene,
                                 const DetectionSequence& detections,
                                 const PlainOptions& options) {
  EstimatorPair estimators = MakeEstimators(options.estimators);
  Tracker tracker(
      {scene.cameras, scene.skeleton, scene.frame_rate_hz, KeptMatches::kNone},
      detections.header.skeleton, options.tracker, estimators.feedback,
      estimators.output);
  std::vector<TrackFrame> frames;
  for (const DetectionFrame& frame : detections.frames) {
    tracker.Process(frame, &frames);
  }
  tracker.Finish(&frames);
  return frames;
}

// Errors [m] of the found joints that are inliers in every view; found and true
// people of a frame are paired one-to-one. Expects no more found than true
// people in any frame.
std::vector<double> ErrorsOf(const Scene& scene,
                             const DetectionSequence& detections,
                             const std::vector<TrackFrame>& tracks) {
  const TrackSequence truth = TruthFor(scene, detections);
  const int all = static_cast<int>(scene.cameras.size());
  EXPECT_EQ(tracks.size(), truth.frames.size());
  for (size_t f = 0; f < std::min(tracks.size(), truth.frames.size()); ++f) {
    EXPECT_LE(tracks[f].people.size(), truth.frames[f].people.size()) << f;
  }
  std::vector<double> errors_m;
  const TrackSequence found = {truth.header, tracks};
  const JointPairs joints = CommonJoints(scene.skeleton, scene.skeleton);
  for (const PersonPair& pair : PairPeople(truth, found, joints, kNoGate, {})) {
    if (pair.found == nullptr) continue;
    for (size_t j = 0; j < pair.truth->joints.size(); ++j) {
      if (pair.found->inlier_views[j] != all) continue;
      errors_m.push_back(
          (pair.found->joints[j].position_m - pair.truth->joints[j].position_m)
              .norm());
    }
  }
  return errors_m;
}

double RootMeanSquareOf(const std::vector<double>& errors_m) {
  double sum = 0.0;
  for (const double error_m : errors_m) sum += error_m * error_m;
  return std::sqrt(sum / static_cast<double>(errors_m.size()));
}

TEST(TruthTest, ReconstructsExactDetectionsOfDistortingCameras) {
  const Scene scene = SmallScene({-0.2, 0.06, 0.001, -0.002, -0.005});
  PlainOptions options;
  options.tracker.reconstruction.joints_filter = true;
  const DetectionSequence detections = Observe(scene, NoiseOptions(), nullptr);
  const std::vector<double> errors_m =
      ErrorsOf(scene, detections, TrackAll(scene, detections, options));
  // 3 people, 200 frames less the two before confirmation, 25 joints.
  EXPECT_GT(errors_m.size(), 3u * 198u * 25u * 9u / 10u);
  // The lens is inverted to 1e-7 of the focal length at worst: 1e-6 m at 10 m.
  EXPECT_LT(*std::max_element(errors_m.begin(), errors_m.end()), 1e-6);
}

// Cameras that capture 20 ms before or after the nominal time: a pose belongs
// to its `time` if the detections have each camera's capture time.
TEST(TruthTest, CorrectsKnownClockOffsets) {
  const Scene scene = SmallScene({});
  PlainOptions options;
  options.estimators.mode = Mode::kGraph;
  options.estimators.output = OutputKind::kWindow;
  // The detections are exact, so there is hardly any smoothing, and no noise is
  // learnt.
  options.estimators.graph.pixel_noise_from = NoiseFrom::kFixed;
  options.estimators.graph.process_noise_from = NoiseFrom::kFixed;
  options.estimators.graph.estimate_noise_scale = false;
  options.estimators.graph.sigma_px.fill(0.5);
  options.estimators.graph.min_sigma_px = 0.5;
  const auto rms_m = [&](double offset_s, bool has_times) {
    NoiseOptions noise;
    noise.clock_offset_s = {offset_s, -offset_s, offset_s, -offset_s, offset_s};
    noise.tell_times = has_times;
    const DetectionSequence detections = Observe(scene, noise, nullptr);
    const std::vector<TrackFrame> tracks = TrackAll(scene, detections, options);
    EXPECT_EQ(tracks.size(), scene.times.size());
    for (size_t f = 0; f < tracks.size(); ++f) {
      EXPECT_EQ(tracks[f].time, scene.times[f]);
    }
    const std::vector<double> errors_m = ErrorsOf(scene, detections, tracks);
    EXPECT_GT(errors_m.size(), 5000u);
    return RootMeanSquareOf(errors_m);
  };
  const double no_offset_m = rms_m(0.0, true);
  const double with_times_m = rms_m(0.02, true);
  const double without_times_m = rms_m(0.02, false);
  // Without capture times an offset moves each ray by 20 ms of the motion. With
  // them, only the change of velocity within 20 ms remains: a t^2 / 2 = 2 mm at
  // 10 m/s^2 for each ray, averaged over five cameras about 1 mm.
  EXPECT_LT(with_times_m, no_offset_m + 0.001);
  EXPECT_LT(with_times_m, 0.5 * without_times_m);
}

}  // namespace
}  // namespace kinegraph
