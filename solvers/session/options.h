// All options of a run, as in a configuration.
#ifndef KINEGRAPH_SOLVERS_SESSION_OPTIONS_H_
#define KINEGRAPH_SOLVERS_SESSION_OPTIONS_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/identity/options.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/skeleton/skeleton.h"
#include "core/tracking/options.h"
#include "solvers/cameras/refine_options.h"
#include "solvers/factory.h"

namespace kinegraph {

struct InputOptions {
  double frame_rate_hz = 0.0;  // 0: from the files
  // Number of times the first frame is repeated before the recording, as in the
  // warm-up of the paper's authors; repetitions are not written.
  int64_t repeat_first_frame = 0;
  bool independent_frames = false;  // frames are unrelated in time
  // Skip frames of kinegraph's JSON Lines that cannot be read.
  bool skip_bad_frames = false;
  // View -> rate [Hz] at which its files count frames, if it is not that of the
  // recording.
  std::map<std::string, std::string> view_frame_rate;
  // View -> offset subtracted from the frame numbers of its files.
  std::map<std::string, std::string> view_frame_offset;

  void Describe(OptionVisitor& visitor);
};

struct OutputOptions {
  bool observations = false;  // also write matches and weights

  void Describe(OptionVisitor& visitor);
};

struct RunOptions {
  EstimatorOptions estimators;
  InputOptions input;
  std::string skeleton;  // of the tracks; empty: that of the detections
  CameraReadOptions cameras;
  RefineOptions refine;  // part of the cameras table
  // Size of the subject (subject_scale.h); 0: measured.
  double subject_m = 0.0;
  DetectionReadOptions detections;
  TrackerOptions tracker;
  LinkOptions identity;
  OutputOptions output;
  std::vector<Skeleton> user_skeletons;  // tables [skeletons.NAME]

  void Describe(OptionVisitor& visitor);
};

// The options as the run's mode interprets them: paper mode converts the times
// of a track's life into frames at 25 Hz, whatever the frame rate, and never
// backfills, bridges gaps, runs a second pass or links, regardless of the keys;
// graph mode counts seconds and associates by AssociationRules::kGraph.
// Independent frames are linked in neither mode. Every run applies this; it is
// idempotent.
RunOptions WithRulesOfMode(RunOptions options);

// Reads a configuration with the command line's changes: `set` and `mode` as in
// --set and --mode, or empty.
RunOptions ReadRunOptions(const std::string& config_path,
                          const std::string& set, const std::string& mode);

// The same for a configuration given as text; an empty text leaves every key at
// its default.
RunOptions ParseRunOptions(const std::string& toml, const std::string& set,
                           const std::string& mode);

// Options for opening the detections of a run: the rates, offsets and
// skip_bad_frames are filled in from [input]. Throws OptionError for a rate or
// offset of a view that is not a valid number.
DetectionReadOptions DetectionOptionsOf(const RunOptions& options);

// The causal estimator whose predictions the tracker uses in association and in
// the joints filter, without the bias of the detector (graph.view_bias).
EstimatorFactory FeedbackOf(const RunOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_OPTIONS_H_
