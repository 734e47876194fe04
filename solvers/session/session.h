// A tracking run, frame by frame: live, or over a recording.
//
//   kinegraph::Session session(options, request, header);
//   for (const DetectionFrame& frame : recording) {
//     for (const TrackFrame& done : session.Process(frame)) Use(done);
//   }
//   for (const TrackFrame& done : session.Finish()) Use(done);
//   session.summary();  // how many frames, people, poses
//
// Implements everything that a configuration can request, namely choice of
// views, warm-up (repetitions of the first frame, input.repeat_first_frame),
// rules of paper mode, linking of identities and second pass, but no changes to
// cameras and clocks (ready_recording.h).
#ifndef KINEGRAPH_SOLVERS_SESSION_SESSION_H_
#define KINEGRAPH_SOLVERS_SESSION_SESSION_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/data/identity_edit.h"
#include "core/data/pose.h"
#include "core/data/view_bias.h"
#include "core/io/detections/source.h"
#include "solvers/factory.h"
#include "solvers/graph/solve_counts.h"
#include "solvers/noise/learnt_noise.h"
#include "solvers/session/options.h"
#include "solvers/session/scene.h"
#include "solvers/session/subject_scale.h"

namespace kinegraph {

struct StageTimes;  // core/tracking/tracker.h

// Opens the detections of a run at their beginning; called each time they are
// read again.
using SourceOpener = std::function<std::unique_ptr<DetectionSource>()>;

// Counts of a run, for its closing lines and for NAME.summary.json.
struct RunSummary {
  int64_t frames = 0;
  int64_t people = 0;  // identities in the output
  int64_t person_frames = 0;
  // Graph mode: the solver of the result (graph.solver), and counts of the
  // solves for people whose tracks have ended.
  std::string solver;
  SolveCounts solves;
  SubjectScale subject_scale;
};

// Number of passes over the frames.
int PassCount(const RunOptions& options);

// A Session may be passed between threads, but calls must not overlap. Process
// and Finish throw std::logic_error if called during another call of either,
// after Finish, or after an exception in the middle of a frame. Sessions share
// no state, so several may run in parallel.
class Session {
 public:
  // `detections` describes the frames to come: views, skeleton, rate. A second
  // pass needs the frames again in Finish: from `reopen`, which must provide
  // the same frames, or without it from copies kept in memory. With a second
  // pass and `reopen`, the constructor reads the first 500 requested frames to
  // learn which joints are absent (presence.h). Throws InputError or
  // OptionError for inconsistent arguments.
  Session(const RunOptions& options, const RunRequest& request,
          const DetectionHeader& detections, SourceOpener reopen = nullptr);
  // With the caller's estimators instead of those of the options, to observe
  // them or to use another smoother.
  Session(const RunOptions& options, const RunRequest& request,
          const DetectionHeader& detections, EstimatorPair estimators,
          SourceOpener reopen = nullptr);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  const RunScene& scene() const;
  // Processor time by stage of the first pass; null: not measured.
  void set_stage_times(StageTimes* times);
  // Called with every frame of the first pass, the warm-up included, with the
  // used views only. Times are those that the estimators receive: they ascend
  // even if the recording's clock stops or steps back, and long pauses are
  // shortened. Must be set before the first frame.
  void set_frame_listener(std::function<void(const DetectionFrame&)> listener);
  // Called with the number of frames read so far, over both passes; frames kept
  // in memory for the second pass are counted once.
  void set_progress(std::function<void(int64_t)> progress);

  // Processes the next frame, with all views of the header; frames must ascend,
  // and those not requested (RunRequest::frames) are skipped. Returns the
  // frames that became final, ascending; with a second pass, linking or
  // corrections, none before Finish. If times do not ascend, all tracks end, as
  // after a long pause. Throws InputError if frame numbers do not ascend, or if
  // a frame does not match the header (CheckDetectionFrame); the session can
  // then continue with the next frame.
  std::vector<TrackFrame> Process(const DetectionFrame& frame);
  // The same without a copy: swaps the views of `frame` with those of an
  // earlier frame, so that a reader that refills it need not allocate memory.
  std::vector<TrackFrame> Process(DetectionFrame&& frame);
  // Whether `frame` and all later frames are outside RunRequest::frames.
  bool IsPastEnd(int64_t frame) const;
  // Returns the remaining frames. Process must not be called afterwards. Throws
  // InputError for an invalid correction, and std::runtime_error if `reopen`
  // does not provide the same frames again.
  std::vector<TrackFrame> Finish();

  // Counts of the frames returned so far.
  const RunSummary& summary() const;
  // Metres of the world per metre of the run. Tracker and estimators, including
  // the caller's, work in the run's metres; results of Session are in metres of
  // the world. 1, the scale of people, until it is determined, which is before
  // the first track begins.
  const SubjectScale& scale() const;
  // After Finish: data that the output estimators learnt from the recording
  // (graph.pixel_noise_from, graph.process_noise_from, graph.view_bias). ToJson
  // (solvers/noise/learnt_noise.h) converts learnt_noise() to JSON.
  LearntNoise learnt_noise() const;
  ViewBias view_bias() const;
  // After Finish: the changes of identities by linking, then the corrections.
  const std::vector<IdentityEdit>& identity_edits() const;
  // A line for each decision of the linking that could not be applied; normally
  // none.
  const std::vector<std::string>& linking_left_out() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SESSION_H_
