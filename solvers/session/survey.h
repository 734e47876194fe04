// A first examination of a recording: its contents and whether they are
// consistent, before a configuration exists.
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
  std::string cameras;  // paths
  std::string detections;
  RunOptions options;  // initial values, as in configs/default.toml
  std::vector<std::string> without_cameras;  // names of views or cameras
};

// Results of tracking some frames.
struct SurveyTrial {
  RecordingReport report;
  // Evidence on the vertical from people; empty for a non-human skeleton.
  Stance stance = Stance(Skeleton());
  // Poses or clocks of some cameras contradict the others, and nothing else
  // seems wrong: refinement is recommended (cameras.refine,
  // cameras.refine_clock).
  bool cameras_are_off = false;
  bool clocks_are_off = false;
  // The reason, as text, if cameras have errors but their refinement is not
  // offered.
  std::string left;
};

struct RecordingSurvey : SurveyTrial {
  DetectionHeader detections;
  int64_t frames = 0;
  int64_t first_frame = 0;
  int64_t last_frame = 0;
  int64_t frames_tried = 0;  // tracked for the report

  CameraRig cameras;  // in the unit determined
  std::string unit;   // "auto" if the file's own unit is right
  // View -> camera as given, or where only the order of the names decided.
  std::map<std::string, std::string> map;
  // Names of the cameras, if not all in the file are used.
  std::vector<std::string> use;
  PairedBy paired_by = PairedBy::kMap;
  // Joints required of a new person (initialisation.min_joints and
  // min_common_joints, of 17) where detections have few; else as in the
  // options.
  std::optional<int> min_joints;
};

// Reads cameras and detections and tracks up to 250 frames in which two views
// show people: with the calibration's own unit and, if people then have no
// plausible height, with others. Throws InputError when something cannot be
// read or paired, or when the frame rate is unknown, which is never guessed.
RecordingSurvey SurveyRecording(const SurveyRequest& request);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SURVEY_H_
