// Everything a configuration can say of a run.
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
  double frame_rate_hz = 0.0;  // 0: the files tell it
  // Feeds the first frame so often before the recording, as the authors'
  // warm-up; what is fed again is not written.
  int64_t repeat_first_frame = 0;
  bool independent_frames = false;  // single frames, no motion between them
  bool skip_bad_frames = false;     // of our own detections
  // View -> rate [Hz] at which its files count frames, where it is another.
  std::map<std::string, std::string> view_frame_rate;
  // View -> what is taken from the frame numbers of its files.
  std::map<std::string, std::string> view_frame_offset;

  void Describe(OptionVisitor& visitor);
};

struct OutputOptions {
  bool observations = false;  // write matches and weights too

  void Describe(OptionVisitor& visitor);
};

struct RunOptions {
  EstimatorOptions estimators;
  InputOptions input;
  std::string skeleton;  // of the tracks; empty: the detections'
  CameraReadOptions cameras;
  RefineOptions refine;  // in the table of the cameras
  // Size of the subject (subject_scale.h); 0: measured.
  double subject_m = 0.0;
  DetectionReadOptions detections;
  TrackerOptions tracker;
  LinkOptions identity;
  OutputOptions output;
  std::vector<Skeleton> user_skeletons;  // tables [skeletons.NAME]

  void Describe(OptionVisitor& visitor);
};

// The options as the run's mode means them: paper mode counts a track's life in
// frames of 25 Hz and never backfills, associates again, extrapolates or links,
// whatever the keys say; graph mode counts seconds. Every run applies this; it
// changes nothing when applied again.
RunOptions WithRulesOfMode(RunOptions options);

// Reads a configuration with what the command line changes in it: `set` as
// --set takes it, `mode` empty or as --mode takes it.
RunOptions ReadRunOptions(const std::string& config_path,
                          const std::string& set, const std::string& mode);

// The same for a configuration that is a text already; no text leaves every
// key at its default.
RunOptions ParseRunOptions(const std::string& toml, const std::string& set,
                           const std::string& mode);

// Options for opening the detections of a run: frame rate and skeleton filled
// in from the other tables.
DetectionReadOptions DetectionOptionsOf(const RunOptions& options);

// Whose prediction the joints filter uses.
EstimatorFactory FeedbackOf(const RunOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_OPTIONS_H_
