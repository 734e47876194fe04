// Calibrates the cameras of a recording from its people (solvers/rig), with
// lengths in metres, z up and the floor at zero.
#ifndef KINEGRAPH_SOLVERS_SESSION_CALIBRATE_RECORDING_H_
#define KINEGRAPH_SOLVERS_SESSION_CALIBRATE_RECORDING_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/io/configuration/refinement_record.h"
#include "solvers/rig/rig.h"
#include "solvers/session/ground.h"
#include "solvers/session/options.h"

namespace kinegraph {

// The known length that determines the scale; by default people's mean stature.
struct KnownLength {
  enum class Kind { kPopulation, kStature, kDistance, kCameras };
  Kind kind = Kind::kPopulation;
  double metres = 0.0;
  std::string a;  // joints or views
  std::string b;
};

struct CalibrationInput {
  CameraRig cameras;  // intrinsics, with the names of the views
  // See RigInput for these.
  double focal_sigma = 0.0;
  bool focal_stated = false;
  bool lenses_known = true;
  bool in_step = false;
  std::function<void(const std::string& stage, int done, int total)> progress;
  KnownLength length;
};

struct RecordingCalibration {
  std::vector<std::string> view_names;  // one per view of the rig
  RigResult rig;
  // Cameras of the calibrated views (rig.used), in metres or, if the scale is
  // unknown, in the unit of the rig; with z up from the floor if `ground` is
  // set.
  CameraRig cameras;
  std::optional<Ground> ground;
  double metres_per_unit = 1.0;  // factor of the rig's lengths
  // Standard deviation of the logarithm of all lengths; 1 if the scale is
  // unknown.
  double scale_sigma = 0.0;
  double stature_m = 0.0;   // of the people; 0: not measured
  RefinementRecord record;  // clocks and covariance, for cameras.json
};

// Throws InputError or OptionError if a joint, a view or the frame rate is
// missing.
RecordingCalibration CalibrateRecording(const RunOptions& options,
                                        const CalibrationInput& input,
                                        const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_CALIBRATE_RECORDING_H_
