// One tracking run, from files to frames: shared by every command that tracks.
#ifndef KINEGRAPH_APPS_COMMON_TRACK_RUN_H_
#define KINEGRAPH_APPS_COMMON_TRACK_RUN_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/common/app.h"
#include "core/base/options.h"
#include "core/io/calibration.h"
#include "core/io/config.h"
#include "core/io/detection_source.h"
#include "core/tracking/options.h"
#include "core/tracking/replay.h"
#include "core/tracking/tracker.h"
#include "solvers/factory.h"

namespace kinegraph {

struct InputOptions {
  double frame_rate_hz = 0.0;  // 0: the files tell it
  // Feeds the first frame so often before the take, as the authors' warm-up;
  // what is fed again is not written.
  int64_t repeat_first_frame = 0;

  void Describe(OptionVisitor& visitor);
};

struct OutputOptions {
  bool observations = false;  // write matches and weights too

  void Describe(OptionVisitor& visitor);
};

// Everything a configuration can say of a run.
struct RunOptions {
  EstimatorOptions estimators;
  InputOptions input;
  std::string skeleton;  // of the tracks; empty: the detections'
  CameraReadOptions cameras;
  DetectionReadOptions detections;
  TrackerOptions tracker;
  OutputOptions output;
  std::vector<Skeleton> user_skeletons;  // tables [skeletons.NAME]

  void Describe(OptionVisitor& visitor);
};

// Reads a configuration with what the command line changes in it: `set` as
// --set takes it, `mode` empty or as --mode takes it.
RunOptions ReadRunOptions(const std::string& config_path,
                          const std::string& set, const std::string& mode);

// Detections held in memory, as a source that can be read again and again.
class MemorySource final : public DetectionSource {
 public:
  // `sequence` must outlive the source.
  explicit MemorySource(const DetectionSequence& sequence)
      : sequence_(&sequence) {}
  const DetectionHeader& header() const override { return sequence_->header; }
  bool Next(DetectionFrame* frame) override;
  int64_t frame_count() const override {
    return static_cast<int64_t>(sequence_->frames.size());
  }

 private:
  const DetectionSequence* sequence_;
  size_t next_ = 0;
};

// What a run needs besides its options.
struct RunRequest {
  CameraRig cameras;                         // as the calibration file has them
  std::vector<std::string> without_cameras;  // names of views or cameras
  std::vector<FrameRange> frames;            // ascending; empty: all
  int threads = 1;
};

// The whole of a run but its frames.
struct RunScene {
  SceneModel model;                     // cameras in the order of used views
  std::vector<int> used_views;          // indices into the source's views
  std::vector<std::string> view_names;  // of the used views
  TrackHeader header;                   // of the tracks to come
};

// Pairs views with cameras, leaves out what is not wanted, settles skeleton and
// frame rate. Throws InputError or OptionError for what does not fit.
RunScene PrepareScene(const RunOptions& options, const RunRequest& request,
                      const DetectionHeader& detections);

// Options for opening the detections of a run: frame rate and skeleton filled
// in from the other tables.
DetectionReadOptions DetectionOptionsOf(const RunOptions& options);

// Opens the detections, once for each pass.
using SourceOpener = std::function<std::unique_ptr<DetectionSource>()>;

// Counts of a run, for its closing line.
struct RunSummary {
  int64_t frames = 0;
  int64_t people = 0;  // identities written
  int64_t person_frames = 0;
};

// Tracks all frames of the source; `write` gets each finished frame in order,
// `progress` the number of frames read so far, over both passes if there are
// two (may be null).
RunSummary RunTracking(const RunOptions& options, const RunRequest& request,
                       const RunScene& scene, const SourceOpener& open_source,
                       const std::function<void(const TrackFrame&)>& write,
                       const std::function<void(int64_t)>& progress = nullptr,
                       StageTimes* stage_times = nullptr);
// How often RunTracking reads the take.
int PassCount(const RunOptions& options);

// The same for detections in memory, giving the whole result.
TrackSequence TrackSequenceOf(const RunOptions& options,
                              const RunRequest& request,
                              const DetectionSequence& detections);

// A run whose matches are kept (core/tracking/replay.h).
struct FrozenRun {
  RunScene scene;
  // As the tracker was fed: used views alone, the warm-up before `first_frame`.
  DetectionSequence detections;
  int64_t first_frame = 0;  // that is written
  FrozenMatches matches;
  TrackSequence tracks;  // what the run itself wrote
};

// Tracks detections in memory and freezes the matches. There is one pass: a
// second one (tracking.second_pass) is left out.
FrozenRun FreezeTracking(const RunOptions& options, const RunRequest& request,
                         const DetectionSequence& detections);

// Whose prediction the joints filter uses.
EstimatorFactory FeedbackOf(const RunOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TRACK_RUN_H_
