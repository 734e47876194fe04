// Truth in, truth out, through the whole front end: synthetic detections are
// tracked, and what comes out is compared with the scene.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <utility>
#include <vector>

#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "core/tracking/tracker.h"
#include "solvers/factory.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

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

const std::vector<double>& Distortion() {
  static const std::vector<double> distortion = {-0.2, 0.06, 0.001, -0.002,
                                                 -0.005};
  return distortion;
}

// The triangulation as it is: nothing smoothed, no view filtered out.
struct PlainOptions {
  EstimatorOptions estimators;
  TrackerOptions tracker;

  PlainOptions() {
    estimators.mode = Mode::kPaper;
    estimators.gaussian.smooth = false;
    tracker.reconstruction.joints_filter = false;
    tracker.initialisation.alpha_filter_px = 1e6;
    // People are followed from the last pose: 3 m/s at 4 m depth are 24 px in a
    // frame, and 4 px of noise come on top.
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

double MeanDistanceOf(const Pose3d& a, const Pose3d& b) {
  double sum = 0.0;
  for (size_t j = 0; j < a.size(); ++j) {
    sum += (a[j].position_m - b[j].position_m).norm();
  }
  return sum / static_cast<double>(a.size());
}

// The true pose that a tracked one is nearest to, at the frame's own time.
const Pose3d& NearestTruth(const TrackFrame& truth, const Pose3d& pose) {
  const Pose3d* nearest = &truth.people.front().joints;
  for (const PersonPose& person : truth.people) {
    if (MeanDistanceOf(person.joints, pose) < MeanDistanceOf(*nearest, pose)) {
      nearest = &person.joints;
    }
  }
  return *nearest;
}

struct JointError {
  Vector3d truth_m;
  Vector3d error_m;
};

// Errors of all joints that every camera supports.
std::vector<JointError> ErrorsOf(const Scene& scene,
                                 const DetectionSequence& detections,
                                 const std::vector<TrackFrame>& tracks) {
  const TrackSequence truth = TruthFor(scene, detections);
  const int all = static_cast<int>(scene.cameras.size());
  std::vector<JointError> errors;
  EXPECT_EQ(tracks.size(), truth.frames.size());
  if (tracks.size() != truth.frames.size()) return errors;
  for (size_t f = 0; f < tracks.size(); ++f) {
    for (const PersonPose& person : tracks[f].people) {
      const Pose3d& pose = NearestTruth(truth.frames[f], person.joints);
      for (size_t j = 0; j < pose.size(); ++j) {
        if (person.inlier_views[j] != all) continue;
        errors.push_back({pose[j].position_m,
                          person.joints[j].position_m - pose[j].position_m});
      }
    }
  }
  return errors;
}

double RootMeanSquareOf(const std::vector<JointError>& errors) {
  double sum = 0.0;
  for (const JointError& joint : errors) sum += joint.error_m.squaredNorm();
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

TEST(TruthTest, ExactDetectionsOfDistortingCamerasGiveTheSceneBack) {
  const Scene scene = SmallScene(Distortion());
  PlainOptions options;
  options.tracker.reconstruction.joints_filter = true;
  const DetectionSequence detections = Observe(scene, NoiseOptions(), nullptr);
  const std::vector<JointError> errors =
      ErrorsOf(scene, detections, TrackAll(scene, detections, options));
  // 3 people, 200 frames less the two before confirmation, 25 joints.
  EXPECT_GT(errors.size(), 3u * 198u * 25u * 9u / 10u);
  // The lens is inverted to 1e-7 of the focal length at worst: 1e-6 m at 10 m.
  double worst_m = 0.0;
  for (const JointError& joint : errors) {
    worst_m = std::max(worst_m, joint.error_m.norm());
  }
  EXPECT_LT(worst_m, 1e-6);
}

// Cameras that look 20 ms before or after the beat: a pose belongs to its
// `time` if the detections tell when each camera looked.
TEST(TruthTest, ToldClockOffsetsAreUndoneAtTheFramesTime) {
  const Scene scene = SmallScene({});
  PlainOptions options;
  options.estimators.mode = Mode::kGraph;
  options.estimators.output = OutputKind::kWindow;
  // These detections are exact: hardly any smoothing, and no noise to learn.
  options.estimators.graph.pixel_noise_from = NoiseFrom::kFixed;
  options.estimators.graph.process_noise_from = NoiseFrom::kFixed;
  options.estimators.graph.estimate_noise_scale = false;
  options.estimators.graph.sigma_px.fill(0.5);
  options.estimators.graph.min_sigma_px = 0.5;
  const auto rms_m = [&](double offset_s, bool told) {
    NoiseOptions noise;
    noise.clock_offset_s = {offset_s, -offset_s, offset_s, -offset_s, offset_s};
    noise.tell_times = told;
    const DetectionSequence detections = Observe(scene, noise, nullptr);
    const std::vector<TrackFrame> tracks = TrackAll(scene, detections, options);
    EXPECT_EQ(tracks.size(), scene.times.size());
    for (size_t f = 0; f < tracks.size(); ++f) {
      EXPECT_EQ(tracks[f].time, scene.times[f]);
    }
    const std::vector<JointError> errors = ErrorsOf(scene, detections, tracks);
    EXPECT_GT(errors.size(), 5000u);
    return RootMeanSquareOf(errors);
  };
  const double without_m = rms_m(0.0, true);
  const double told_m = rms_m(0.02, true);
  const double untold_m = rms_m(0.02, false);
  // Untold, an offset moves each ray by 20 ms of the motion. Told, only the
  // change of velocity within 20 ms is left: a t^2 / 2 = 2 mm at 10 m/s^2 for
  // each ray, averaged over five cameras about 1 mm.
  EXPECT_LT(told_m, without_m + 0.001);
  EXPECT_LT(told_m, 0.5 * untold_m);
}

}  // namespace
}  // namespace kinegraph
