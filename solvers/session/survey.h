// A first examination of a recording before a configuration exists: its
// contents and whether they are consistent.
#ifndef KINEGRAPH_SOLVERS_SESSION_SURVEY_H_
#define KINEGRAPH_SOLVERS_SESSION_SURVEY_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/data/stance.h"
#include "core/io/detections/view_pairing.h"
#include "solvers/session/options.h"
#include "solvers/session/recording_report.h"

namespace kinegraph {

struct SurveyRequest {
  std::string cameras;     // path
  std::string detections;  // path
  RunOptions options;      // initial values, as in configs/default.toml
  std::vector<std::string> without_cameras;  // names of views or cameras
};

// Results of tracking some frames.
struct SurveyTrial {
  RecordingReport report;
  // People's evidence about the vertical; empty for a non-human skeleton.
  Stance stance = Stance(Skeleton());
  // Whether poses or clocks of some cameras contradict the other cameras and
  // nothing else seems wrong; refinement is then recommended (cameras.refine,
  // cameras.refine_clock).
  bool cameras_are_off = false;
  bool clocks_are_off = false;
  // If cameras have errors but their refinement is not recommended, the reason
  // as text.
  std::string left;
};

struct RecordingSurvey : SurveyTrial {
  DetectionHeader detections;
  int64_t frames = 0;
  int64_t first_frame = 0;
  int64_t last_frame = 0;
  int64_t frames_tried = 0;  // number of frames tracked for the report

  CameraRig cameras;  // in the unit determined
  std::string unit;   // "auto": as specified by the file or the options
  // View -> camera: the configured map, or the pairing by order of names.
  std::map<std::string, std::string> map;
  // Names of the used cameras if the request excludes any; else empty.
  std::vector<std::string> use;
  PairedBy paired_by = PairedBy::kMap;
  // Recommended initialisation.min_joints and min_common_joints (of 17) if
  // detections have few joints; nullopt if the options suffice.
  std::optional<int> min_joints;
};

// Reads cameras and detections and tracks up to 250 frames from the first one
// in which two views show people (if heights cannot be measured there, the 250
// consecutive frames with the most joints): with the calibration's own unit
// and, if people's heights are then implausible or unknown, with other units.
// Throws InputError if something cannot be read or paired, if there are no
// frames, or if the frame rate, which is never guessed, is unknown.
RecordingSurvey SurveyRecording(const SurveyRequest& request);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SURVEY_H_
