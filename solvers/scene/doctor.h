// Says what is wrong with a calibration and the clocks of a recording, from
// calibration and 2D detections alone, and how sure that is.
//
// First without tracking: which reading of the file makes the views agree, and
// which lag between them. Then with the tracker's own matches under that
// reading: single cameras, lenses, clocks to a fraction of a frame.
#ifndef KINEGRAPH_SOLVERS_SCENE_DOCTOR_H_
#define KINEGRAPH_SOLVERS_SCENE_DOCTOR_H_

#include <functional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/tracking/replay.h"
#include "solvers/cameras/bundle.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {

struct DoctorInput {
  CameraRig cameras;  // one a view of the detections, in their order
  DetectionSequence detections;
  double frame_rate_hz = 0.0;
  // Standard deviations of the cameras and their clocks, where the calibration
  // states them; empty: it states none. What is within three of them is
  // mentioned, and changes nothing.
  std::vector<CameraChange> stated_sigma;
  // How the file's lengths were read: units a metre (1, 100, 1000), and
  // whether cameras.unit may change that.
  double units_per_metre = 1.0;
  bool unit_can_be_set = true;
  // Tracks detections with cameras and freezes the matches.
  std::function<FrozenMatches(const CameraRig&, const DetectionSequence&)>
      match;
};

struct DoctorOptions {
  int frames_to_look_at = kFramesToLookAt;
  double longest_lag_s = kLongestLagS;
  bool looks_for_break = true;  // for a camera that moved in the middle
  BundleOptions bundle;

  DoctorOptions() {
    bundle.segments.max_segments = 500;
    bundle.max_iterations = 12;
  }
};

struct Finding {
  std::string kind;         // "unit", "convention", "lens", "shift", ...
  std::string camera;       // a view's camera; empty: all of them
  double confidence = 0.0;  // 0 .. 1; findings that fit equally share it
  double before_px = 0.0;   // residual as the calibration is read
  double after_px = 0.0;    // with the fix
  std::string fix;          // what to type, or to do
  std::string evidence;     // in words, with figures
  // Whether it is beyond what a detector's bias does; else it is mentioned, and
  // changes nothing.
  bool told = true;
};

// Fixes that need the recording's own files: RECORDING stands for them, INPUTS
// for them and the configuration, and the commands put them in (NameInputs). Of
// the first the command that writes cameras.json says where.
inline constexpr char kUseCorrected[] = "--cameras=cameras.json of this report";
inline constexpr char kLookCloser[] = "kinegraph doctor INPUTS --out=doctor";
inline constexpr char kRefineClocks[] = "--set=cameras.refine_clock=true";
inline constexpr char kCalibrateAnew[] =
    "kinegraph calibrate RECORDING --out=cameras.json";

enum class DoctorVerdict { kSound, kSuspect, kNotExamined };
const char* ToString(DoctorVerdict verdict);

struct Diagnosis {
  DoctorVerdict verdict = DoctorVerdict::kSound;
  bool sound() const { return verdict == DoctorVerdict::kSound; }
  std::vector<Finding> findings;  // the surest first within their stage
  CameraRig cameras;              // corrected; as DoctorInput::cameras
  double stature_m = 0.0;  // of the people, as they were read; 0: not known
  // What else was seen: statures, matches, residuals. One sentence each.
  std::vector<std::string> notes;
};

Diagnosis Diagnose(const DoctorInput& input, const DoctorOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_DOCTOR_H_
