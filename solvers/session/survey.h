// A first look at a recording: what it is made of and whether its parts fit,
// before anybody has written a configuration for it.
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
  RunOptions options;  // to start from, as configs/default.toml has them
  std::vector<std::string> without_cameras;  // names of views or cameras
};

// What tracking some frames tells.
struct SurveyTrial {
  RecordingReport report;
  // How people stand in them; those whose skeleton is not human do not.
  Stance stance = Stance(Skeleton());
  // Some cameras see people beside where, or at another time than, the others
  // put them, and nothing else looks wrong: worth to be refined
  // (cameras.refine, cameras.refine_clock).
  bool cameras_are_off = false;
  bool clocks_are_off = false;
  // Why the refinement of cameras that are off is not offered, in words.
  std::string left;
};

struct RecordingSurvey : SurveyTrial {
  DetectionHeader detections;
  int64_t frames = 0;
  int64_t first_frame = 0;
  int64_t last_frame = 0;
  int64_t frames_tried = 0;  // that were tracked for the report

  CameraRig cameras;  // in the unit that was settled on
  std::string unit;   // "auto" where the file's own is right
  // View -> camera as given, or where nothing but the order of the names tells.
  std::map<std::string, std::string> map;
  // Names of the cameras, where not all of the file's are used.
  std::vector<std::string> use;
  PairedBy paired_by = PairedBy::kMap;
  // What a new person should need (initialisation.min_joints and
  // min_common_joints, of 17) where detections show few; else as in the
  // options.
  std::optional<int> min_joints;
};

// Reads cameras and detections and tracks up to 250 frames in which two views
// show people: with the calibration's own unit, and where people come out as no
// person is tall, with others.
// Throws InputError when something cannot be read or paired, or when nothing
// tells the frame rate, which is never guessed.
RecordingSurvey SurveyRecording(const SurveyRequest& request);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SURVEY_H_
