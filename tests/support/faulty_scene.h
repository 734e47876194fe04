// Short synthetic recordings whose calibration or clocks are deliberately
// wrong, for tests of their detection.
#ifndef KINEGRAPH_TESTS_SUPPORT_FAULTY_SCENE_H_
#define KINEGRAPH_TESTS_SUPPORT_FAULTY_SCENE_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "core/tracking/replay.h"
#include "solvers/session/diagnose.h"

namespace kinegraph::testing {

struct FaultySceneOptions {
  // Implicit, so that tests can pass {seed, cameras, people, seconds}.
  // NOLINTNEXTLINE(google-explicit-constructor)
  FaultySceneOptions(uint64_t of_seed = 1, int camera_count = 5,
                     int people_count = 4, double seconds = 8.0)
      : seed(of_seed),
        cameras(camera_count),
        people(people_count),
        duration_s(seconds) {}

  uint64_t seed;
  int cameras;
  int people;
  double duration_s;
  double frame_rate_hz = 25.0;
  double noise_px = 2.0;
  std::string skeleton = "coco17";
  std::vector<double> distortion;  // of the lenses, as MakeLens takes it
  // One per view, or none; not included in the capture times of the detections.
  std::vector<double> clock_offset_s;
  // [s/s], one per view, or none; the offsets change once per second.
  std::vector<double> clock_drift;
  // The ring is not closed, because the cameras of an evenly filled ring are
  // interchangeable.
  double arc_deg = 290.0;
  // Tracks files whose people replace simulated ones, each with a position and
  // rotation drawn from `seed`, and the times [s] at which they appear (0 if
  // not given).
  std::vector<std::string> clips;
  std::vector<double> clip_start_s;
};

struct FaultyScene {
  Scene scene;        // the truth
  CameraRig cameras;  // as calibrated; the truth until a test adds a fault
  DetectionSequence detections;
};

// A scene with Gaussian pixel noise, 2 % outliers and 3 % missing joints.
FaultyScene MakeFaultyScene(const FaultySceneOptions& options);

// Adds persistent detector biases: one per person, joint and view, drawn from
// `seed` (log-normal, median 10 mm, 90th percentile 35 mm) times `scale`, at
// the joint's depth. Real detectors have such biases (docs/doctor.md).
void AddLastingOffsets(uint64_t seed, double scale, FaultyScene* scene);

// `camera` rotated by `degrees` about an axis drawn from `seed`.
Camera Turned(const Camera& camera, double degrees, uint64_t seed);
// `camera` with its principal point shifted, or its focal length multiplied by
// `factor`.
Camera Shifted(const Camera& camera, double x_px, double y_px);
Camera Magnified(const Camera& camera, double factor);
// `camera` without lens distortion, as if the terms had been omitted.
Camera WithoutLens(const Camera& camera);
// `camera` with other extrinsics.
Camera WithExtrinsics(const Camera& camera, const Eigen::Matrix3d& R,
                      const Eigen::Vector3d& t);

// Changes each joint of a view's detections, from frame index `from` on.
void ChangeJoints(FaultyScene* scene, size_t view,
                  const std::function<void(Keypoint*)>& change,
                  size_t from = 0);

// Rotates the camera of view `v` from frame index `from` on, as if knocked: its
// detections move with the image (only for cameras without lens distortion),
// `cameras` does not change.
void TurnCameraFrom(size_t from, size_t v, double degrees, uint64_t seed,
                    FaultyScene* scene);

// Runs the doctor with default options, like the command.
Diagnosis DiagnoseScene(const FaultyScene& scene);
// The tracker's matches with scene.cameras, in paper mode.
FrozenMatches MatchesOf(const FaultyScene& scene);

// Angle [degrees] by which the rotations of two cameras differ.
double AngleBetween(const Camera& a, const Camera& b);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_FAULTY_SCENE_H_
