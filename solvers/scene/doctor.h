// Finds errors of a calibration and of a recording's clocks, from the
// calibration and the 2D detections alone, with a confidence for each finding.
//
// First, without tracking, searches the reading (interpretation) of the files
// and the lags under which the views agree; then, with the tracker's matches
// under that reading, examines individual cameras, lenses, and clocks to a
// fraction of a frame.
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
  CameraRig cameras;  // one per view of the detections, in their order
  DetectionSequence detections;  // with a known frame rate
  // Standard deviations of the cameras and their clocks, if the calibration
  // reports them; else empty. Changes within three standard deviations are
  // mentioned but not applied. Zero: unknown.
  std::vector<CameraChange> stated_sigma;
  // How the calibration file's lengths were read: units per metre (1, 100,
  // 1000), and whether cameras.unit may change that.
  double units_per_metre = 1.0;
  bool unit_can_be_set = true;
  bool independent_frames = false;  // frames are unrelated in time
  // Tracks detections with cameras and freezes the matches. If empty, only the
  // examinations without tracking are made.
  std::function<FrozenMatches(const CameraRig&, const DetectionSequence&)>
      match;
};

struct DoctorOptions {
  double longest_lag_s = kLongestLagS;
  // Whether to search for a camera that was moved during the recording.
  bool looks_for_break = true;
  BundleOptions bundle;

  DoctorOptions() {
    bundle.segments.max_segments = 500;
    bundle.max_iterations = 12;
  }
};

struct Finding {
  std::string kind;         // "unit", "convention", "lens", "shift", ...
  std::string camera;       // the view's camera; empty: all cameras
  double confidence = 0.0;  // 0 .. 1; divided among findings that fit equally
  double before_px = 0.0;   // residual before the fix; 0: not measured
  double after_px = 0.0;    // with the fix
  std::string fix;          // a command, a flag, or what to do
  std::string evidence;     // a sentence, with figures
  // False if the detector's bias or the stated uncertainty of the calibration
  // could be as large: then the finding is only mentioned, not applied.
  bool significant = true;
};

// In fixes, RECORDING stands for the recording's files and INPUTS for these and
// the configuration; commands replace both (NameInputs). A command that writes
// cameras.json replaces kUseCorrected by a flag with its path.
inline constexpr char kUseCorrected[] = "--cameras=cameras.json of this report";
inline constexpr char kLookCloser[] = "kinegraph doctor INPUTS --out=doctor";
inline constexpr char kRefineClocks[] = "--set=cameras.refine_clock=true";
inline constexpr char kCalibrateAnew[] =
    "kinegraph calibrate RECORDING --out=cameras.json";

// kSuspect: there is a significant finding. Otherwise kSound, or kNotExamined
// if too few people or matches were found to examine the set-up.
enum class DoctorVerdict { kSound, kSuspect, kNotExamined };
const char* ToString(DoctorVerdict verdict);

struct Diagnosis {
  DoctorVerdict verdict = DoctorVerdict::kSound;
  std::vector<Finding> findings;  // in the order in which they were found
  CameraRig cameras;              // corrected, one per view of DoctorInput
  // Stature of the people, before the unit is corrected; 0: unknown.
  double stature_m = 0.0;
  // Further observations: statures, matches, residuals. One sentence each.
  std::vector<std::string> notes;
};

Diagnosis Diagnose(const DoctorInput& input, const DoctorOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_DOCTOR_H_
