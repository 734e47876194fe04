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
#include "solvers/scene/bundle.h"

namespace kinegraph {

struct DoctorInput {
  CameraRig cameras;  // one a view of the detections, in their order
  DetectionSequence detections;
  double frame_rate_hz = 0.0;
  // How the file's lengths were read: units a metre (1, 100, 1000), and
  // whether cameras.unit may change that.
  double units_per_metre = 1.0;
  bool unit_can_be_set = true;
  // Tracks detections with cameras and freezes the matches.
  std::function<FrozenMatches(const CameraRig&, const DetectionSequence&)>
      match;
};

struct DoctorOptions {
  int frames_to_look_at = 40;
  double longest_lag_s = 10.0;
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

enum class DoctorVerdict { kSound, kSuspect, kNotExamined };
const char* ToString(DoctorVerdict verdict);

struct Diagnosis {
  DoctorVerdict verdict = DoctorVerdict::kSound;
  bool sound() const { return verdict == DoctorVerdict::kSound; }
  std::vector<Finding> findings;  // the surest first within their stage
  CameraRig cameras;              // corrected; as DoctorInput::cameras
  // What else was seen: statures, matches, residuals. One sentence each.
  std::vector<std::string> notes;
};

Diagnosis Diagnose(const DoctorInput& input, const DoctorOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_DOCTOR_H_
