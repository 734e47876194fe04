// A tracking run, frame by frame: live, or over a recorded recording.
//
//   kinegraph::Session session(options, request, header);
//   for (const DetectionFrame& frame : take) {
//     for (const TrackFrame& done : session.Process(frame)) Use(done);
//   }
//   for (const TrackFrame& done : session.Finish()) Use(done);
//   session.summary();  // how many frames, people, poses
//
// Everything that a configuration can ask for happens here: choice of views,
// warm-up, rules of paper mode, linking of identities, second pass.
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

// Opens the detections of a run from their beginning, once for each pass.
using SourceOpener = std::function<std::unique_ptr<DetectionSource>()>;

// Counts of a run, for its closing lines and for NAME.summary.json.
struct RunSummary {
  int64_t frames = 0;
  int64_t people = 0;  // identities written
  int64_t person_frames = 0;
  // Graph mode: which solver wrote the result (graph.solver), and how the
  // solves of the people whose tracks ended went.
  std::string solver;
  SolveCounts solves;
  SubjectScale subject_scale;
};

// How often a run goes over its frames.
int PassCount(const RunOptions& options);

// One call at a time: a Session may be handed from thread to thread, but a call
// while another one is at work throws std::logic_error, as does one after
// Finish or after a call that was stopped in its middle. Sessions share
// nothing: several may be at work in as many threads.
class Session {
 public:
  // `detections` describes the frames to come: views, skeleton, rate. With a
  // second pass the session needs the frames again in Finish: it takes them
  // from `reopen`, which must give the same ones, or, without it, keeps a copy
  // of each. Throws InputError or OptionError for what does not fit together.
  Session(const RunOptions& options, const RunRequest& request,
          const DetectionHeader& detections, SourceOpener reopen = nullptr);
  // With estimators of the caller's own instead of those that the options
  // name: to listen to them, or to write with another smoother.
  Session(const RunOptions& options, const RunRequest& request,
          const DetectionHeader& detections, EstimatorPair estimators,
          SourceOpener reopen = nullptr);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  const RunScene& scene() const;
  // Processor time by stage of the first pass; null: nothing is measured.
  void set_stage_times(StageTimes* times);
  // Sees every frame that the first pass is fed, the warm-up included, with
  // the used views alone and times of the run's own clock, which ascend; set
  // before the first frame.
  void set_frame_listener(std::function<void(const DetectionFrame&)> listener);
  // Sees how many frames were read so far, over both passes.
  void set_progress(std::function<void(int64_t)> progress);

  // The next frame with all views of the header, in ascending order; frames
  // that were not asked for (RunRequest::frames) are passed over. Returns the
  // frames that became final, ascending: possibly none, and none before Finish
  // with a second pass, linking or corrections. Where times do not ascend, or
  // pause for an hour and more, tracks start anew. Throws InputError when frame
  // numbers do not ascend and for a frame that is not as the header says
  // (CheckDetectionFrame); the session can go on with the next one.
  std::vector<TrackFrame> Process(const DetectionFrame& frame);
  // The same without a copy: takes the views, and leaves the memory of earlier
  // ones in `frame`, so that a reader which fills it again need not allocate.
  std::vector<TrackFrame> Process(DetectionFrame&& frame);
  // Whether no later frame can matter: RunRequest::frames end before `frame`.
  bool IsPastEnd(int64_t frame) const;
  // The rest. Nothing may be processed afterwards. Throws InputError for a
  // correction that does not fit.
  std::vector<TrackFrame> Finish();

  // Of the frames returned so far.
  const RunSummary& summary() const;
  // What a metre of tracker and estimators is in the world. Known after the
  // first frame that was given to them; before that the scale of people. What
  // is asked of this object is in the world; estimators of the caller's own see
  // the run's metres.
  const SubjectScale& scale() const;
  // After Finish: what the estimators that were written learnt from the
  // recording (graph.pixel_noise_from, graph.process_noise_from,
  // graph.view_bias). ToJson (solvers/noise/learnt_noise.h) makes JSON of the
  // first.
  LearntNoise learnt_noise() const;
  ViewBias view_bias() const;
  // After Finish: what linking did to identities, then the corrections.
  const std::vector<IdentityEdit>& identity_edits() const;
  // Lines for what linking decided and could not do; none in a sound recording.
  const std::vector<std::string>& linking_left_out() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_SESSION_H_
