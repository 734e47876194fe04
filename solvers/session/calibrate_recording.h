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

// The known length that determines the scale: the mean stature of adults (the
// default, which ignores `metres`), the people's median stature, or the
// distance of two joints or of two cameras.
struct KnownLength {
  enum class Kind { kPopulation, kStature, kDistance, kCameras };
  Kind kind = Kind::kPopulation;
  double metres = 0.0;
  // Names of the two joints (kDistance) or views (kCameras).
  std::string a;
  std::string b;
};

struct CalibrationInput {
  // Intrinsics, paired with the views as in a run (PrepareScene); extrinsics
  // are ignored.
  CameraRig cameras;
  // The members of RigInput with these names.
  double focal_sigma = 0.0;
  bool focal_stated = false;
  bool lenses_known = true;
  bool in_step = false;
  std::function<void(const std::string& stage, int done, int total)> progress;
  KnownLength length;
};

struct RecordingCalibration {
  std::vector<std::string> view_names;  // one per view of the rig
  // From EstimateRig, but also refused if people are upside down with their
  // noses behind the shoulders, because y then counts from the bottom.
  RigResult rig;
  // Cameras of the joined views (rig.used), in metres or, if the scale is
  // unknown, in the unit of the rig; empty if the rig was refused. With a human
  // skeleton z points up, and with `ground` the floor is at z = 0.
  CameraRig cameras;
  std::optional<Ground> ground;
  double metres_per_unit = 1.0;  // the unit is that of rig.cameras
  // Standard deviation of the logarithm of all lengths; 1 if the scale is
  // unknown.
  double scale_sigma = 0.0;
  double stature_m = 0.0;   // of the people; 0: not measured
  RefinementRecord record;  // clocks and covariance, for cameras.json
};

// Throws InputError if a joint or view of the known length does not exist or a
// view of it was not joined to the rig, and what PrepareScene and EstimateRig
// throw.
RecordingCalibration CalibrateRecording(const RunOptions& options,
                                        const CalibrationInput& input,
                                        const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_CALIBRATE_RECORDING_H_
