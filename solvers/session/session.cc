#include "solvers/session/session.h"

#include <algorithm>
#include <atomic>
#include <deque>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/data/checks.h"
#include "core/identity/edits.h"
#include "core/identity/linking.h"
#include "core/tracking/second_pass.h"
#include "core/tracking/tracker.h"
#include "solvers/noise/recording_notes.h"
#include "solvers/session/presence.h"
#include "solvers/session/subject_gauge.h"
#include "solvers/session/subject_scale.h"

namespace kinegraph {
namespace {

// The options with a ledger that counts the estimators' solves.
RunOptions WithLedger(RunOptions options) {
  GraphOptions& graph = options.estimators.graph;
  if (graph.ledger == nullptr) graph.ledger = std::make_shared<SolveLedger>();
  return options;
}

// Longer intervals between frames have the same effect as this one, because
// track lives, gaps and absences end before it. It is short enough for
// covariances to keep their precision.
TimeNs LongestPause(const RunOptions& options, double frame_rate_hz) {
  constexpr double kHour_s = 3600.0;
  const TrackLifeOptions life =
      LifeInFrames(options.tracker.life, frame_rate_hz);
  const double life_frames =
      100.0 + 2.0 * (life.max_age_frames + life.max_gap_frames);
  const double longest_s = std::max({kHour_s, life_frames / frame_rate_hz,
                                     2.0 * options.identity.max_absence_s});
  return FromSeconds(std::min(longest_s, 1e9));
}

// Maps the clock of a recording, which may be reset, stop, or jump by a year,
// to ascending times for the estimators, without pauses longer than
// LongestPause. The output has the recording's own times.
class RecordingClock {
 public:
  explicit RecordingClock(TimeNs longest_pause)
      : longest_pause_(longest_pause) {}

  // Maps the next frame to the run's time. True if the recording's clock
  // stopped or stepped back; no track continues over such a frame. Throws
  // InputError, without changing state, if frame numbers do not ascend.
  bool Enter(DetectionFrame* frame) {
    const TimeNs time = frame->time;
    bool starts_anew = false;
    if (segments_.empty()) {
      segments_.push_back({frame->frame, 0});
    } else {
      if (frame->frame <= last_frame_) {
        throw InputError("frame " + std::to_string(frame->frame) +
                         " comes after frame " + std::to_string(last_frame_) +
                         ", expected frames to ascend");
      }
      starts_anew = time <= last_time_;
      if (starts_anew || time - last_time_ > longest_pause_) {
        const TimeNs pause = starts_anew ? kUnknownPause : longest_pause_;
        const TimeNs before = last_time_ + segments_.back().put_on;
        segments_.push_back({frame->frame, before + (pause - time)});
      }
    }
    last_frame_ = frame->frame;
    last_time_ = time;
    const TimeNs put_on = segments_.back().put_on;
    frame->time += put_on;
    for (ViewDetections& view : frame->views) view.capture_time += put_on;
    return starts_anew;
  }

  // Restores a frame's own time. Frames must ascend; the segments of earlier
  // frames are discarded.
  void Leave(TrackFrame* frame) {
    while (segments_.size() > 1 && segments_[1].first_frame <= frame->frame) {
      segments_.pop_front();
    }
    if (!segments_.empty()) frame->time -= segments_.front().put_on;
  }

 private:
  // The assumed interval if the clock stopped or stepped back.
  static constexpr TimeNs kUnknownPause = 1'000'000'000;
  struct Segment {
    int64_t first_frame = 0;
    TimeNs put_on = 0;  // added to the times of its frames
  };

  const TimeNs longest_pause_;
  std::deque<Segment> segments_;
  int64_t last_frame_ = 0;
  TimeNs last_time_ = 0;  // on the recording's clock
};

// Marks an object as in use during a call; throws if another call is using it.
class Turn {
 public:
  explicit Turn(std::atomic<bool>* taken) : taken_(taken) {
    if (!taken->exchange(true)) return;
    throw std::logic_error(
        "a Session was called during another call; it can be used by one "
        "thread at a time");
  }
  ~Turn() { *taken_ = false; }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  std::atomic<bool>* taken_;
};

// Whether the request selects neither this frame nor a later one.
bool IsPast(const RunRequest& request, int64_t frame) {
  return !request.frames.empty() && frame >= request.frames.back().end;
}

// Learns the presence threshold from the first frames of a recording, if it is
// read twice anyway; the output of a single pass must not depend on later
// frames.
RunScene WithPresence(RunScene scene, const RunOptions& options,
                      const RunRequest& request, const SourceOpener& reopen) {
  constexpr int kFramesToRead = 500;
  constexpr int kEvery = 2;  // errors of consecutive frames are correlated
  if (!reopen || options.estimators.mode == Mode::kPaper ||
      !options.tracker.life.second_pass) {
    return scene;
  }
  PresenceLearner learner(scene.model.cameras);
  const std::unique_ptr<DetectionSource> source = reopen();
  DetectionFrame all_views;
  DetectionFrame used;
  for (int read = 0; read < kFramesToRead && source->Next(&all_views);) {
    if (IsPast(request, all_views.frame)) break;
    if (!ContainsFrame(request.frames, all_views.frame)) continue;
    if (read++ % kEvery != 0) continue;
    KeepUsedViews(scene, &all_views, &used);
    learner.See(used);
  }
  scene.least_confidence = learner.LeastConfidence();
  return scene;
}

}  // namespace

int PassCount(const RunOptions& options) {
  return WithRulesOfMode(options).tracker.life.second_pass ? 2 : 1;
}

// Implementation; only `Session` below uses it.
struct Session::Impl {
  using MakeEstimatorPair = std::function<EstimatorPair(const RunOptions&)>;

  Impl(const RunOptions& options, const RunRequest& request,
       const DetectionHeader& detections, MakeEstimatorPair make_estimators,
       SourceOpener reopen)
      : options_(WithRulesOfMode(options)),
        request_(request),
        scene_(WithPresence(PrepareScene(options_, request_, detections),
                            options_, request_, reopen)),
        detections_(detections),
        clock_(LongestPause(options_, scene_.model.frame_rate_hz)),
        reopen_(std::move(reopen)),
        make_estimators_(std::move(make_estimators)),
        gauge_(scene_.model.cameras, detections_.skeleton, options_.subject_m),
        model_(scene_.model) {
    CheckLinkOptions(options_.identity);
    MakeTracker();
    if (gauge_.is_settled()) SettleScale();
  }

  std::vector<TrackFrame> Process(DetectionFrame* frame) {
    const Turn turn(&taken_);
    RequireUsable();
    CheckDetectionFrame(detections_, *frame);
    CountRead();
    if (!ContainsFrame(request_.frames, frame->frame)) return {};
    KeepUsedViews(scene_, frame, &used_);
    const bool anew = clock_.Enter(&used_);
    unusable_ = "was stopped in the middle of a frame";  // in case it throws
    if (!settled_) gauge_.See(used_);
    if (!settled_ && gauge_.is_settled()) SettleScale();
    if (settled_ || !gauge_.has_begun()) {
      ProcessWaiting();
      ProcessUsed(used_, anew);
    } else {
      waiting_.push_back({used_, anew});
    }
    unusable_ = nullptr;
    return Written();
  }

  std::vector<TrackFrame> Finish() {
    const Turn turn(&taken_);
    RequireUsable();
    unusable_ = "is finished";
    if (!settled_) SettleScale();
    ProcessWaiting();
    tracker_->Finish(&finished_);
    if (!NeedsWholeRecording()) return Written();
    Collect(&first_pass_);
    DecideIdentities();
    return Count(HasSecondPass() ? RunSecondPass() : std::move(first_pass_));
  }

  void RequireUsable() const {
    if (unusable_ == nullptr) return;
    throw std::logic_error(std::string("a Session ") + unusable_ +
                           " and accepts no more frames");
  }

  // A used frame, and whether tracks end before it.
  struct Waiting {
    DetectionFrame frame;
    bool anew = false;
  };

  void MakeTracker() {
    EstimatorPair estimators = make_estimators_(options_);
    notes_ = estimators.notes;
    if (notes_ != nullptr && HasSecondPass()) notes_->ExpectAnotherPass();
    second_pass_estimator_ =
        estimators.output ? estimators.output : estimators.feedback;
    tracker_.emplace(model_, detections_.skeleton, options_.tracker,
                     std::move(estimators.feedback),
                     std::move(estimators.output));
    tracker_->set_threads(request_.threads);
    tracker_->set_stage_times(stage_times_);
  }

  // Called before the first track can begin: no frame processed so far has
  // subjects in two views that could be measured.
  void SettleScale() {
    settled_ = true;
    scale_ = gauge_.Scale();
    summary_.subject_scale = scale_;
    if (scale_.is_one()) return;
    tracker_->Finish(&finished_);
    options_ = scale_.IntoRun(std::move(options_));
    model_.cameras = scale_.IntoRun(model_.cameras);
    MakeTracker();
  }

  void ProcessWaiting() {
    for (const Waiting& one : waiting_) ProcessUsed(one.frame, one.anew);
    waiting_.clear();
  }

  void ProcessUsed(const DetectionFrame& used, bool anew) {
    if (anew) tracker_->StartAnew();
    if (!started_) WarmUp(used);
    Feed(used);
    if (HasSecondPass() && !reopen_) kept_.push_back(used);
    if (NeedsWholeRecording()) Collect(&first_pass_);
  }

  // Final frames that have not been returned yet.
  std::vector<TrackFrame> Written() {
    if (NeedsWholeRecording()) return {};
    std::vector<TrackFrame> written;
    Collect(&written);
    return Count(std::move(written));
  }

  bool HasSecondPass() const { return options_.tracker.life.second_pass; }
  bool NeedsWholeRecording() const {
    return HasSecondPass() || options_.identity.link ||
           !request_.corrections.empty();
  }

  // Links identities and applies the user's corrections, before the second
  // pass, which then estimates each person's trajectory as a whole.
  void DecideIdentities() {
    if (options_.identity.link) {
      edits_ = LinkIdentities(scene_.model.skeleton, scene_.model.frame_rate_hz,
                              options_.identity, &first_pass_, &left_out_);
    }
    const size_t automatic = edits_.size();
    for (IdentityEdit edit : request_.corrections) {
      // A correction that repeats an edit of the linking is already applied.
      const bool done = std::any_of(
          edits_.begin(), edits_.begin() + static_cast<long>(automatic),
          [&](const IdentityEdit& one) { return SameEdit(one, edit); });
      if (done) continue;
      const std::string wrong = ApplyEdit(&edit, &first_pass_);
      if (!wrong.empty()) throw InputError(edit.place + ": " + wrong);
      edits_.push_back(std::move(edit));
    }
  }

  void CountRead() {
    ++frames_read_;
    if (progress_) progress_(frames_read_);
  }

  void WarmUp(const DetectionFrame& first) {
    started_ = true;
    first_frame_ = first.frame;
    const FrameClock clock(scene_.model.frame_rate_hz);
    for (int64_t k = options_.input.repeat_first_frame; k > 0; --k) {
      // A copy with number and time of k frames earlier.
      DetectionFrame earlier = first;
      earlier.frame -= k;
      earlier.time -= clock.TimeOf(k);
      for (ViewDetections& view : earlier.views) {
        view.capture_time -= clock.TimeOf(k);
      }
      Feed(earlier);
    }
  }

  void Feed(const DetectionFrame& frame) {
    if (frame_listener_) frame_listener_(frame);
    tracker_->Process(frame, &finished_);
  }

  // Moves the tracker's finished frames, except the warm-up, to `frames`.
  void Collect(std::vector<TrackFrame>* frames) {
    for (TrackFrame& frame : finished_) {
      if (frame.frame >= first_frame_) frames->push_back(std::move(frame));
    }
    finished_.clear();
  }

  // The next frame of the second pass.
  bool NextAgain(DetectionSource* source, size_t index, DetectionFrame* frame) {
    if (source == nullptr) {
      if (index >= kept_.size()) return false;
      *frame = std::move(kept_[index]);
      return true;
    }
    DetectionFrame all_views;
    while (source->Next(&all_views) && !IsPast(request_, all_views.frame)) {
      CountRead();
      if (!ContainsFrame(request_.frames, all_views.frame)) continue;
      KeepUsedViews(scene_, &all_views, frame);
      clock_again_.Enter(frame);
      return true;
    }
    return false;
  }

  // The tracks from which a correction or the linking deleted frames, by their
  // identities after all edits; these tracks are not extended again.
  std::set<TrackId> Shortened() const {
    std::set<TrackId> people;
    for (const IdentityEdit& edit : edits_) {
      const bool renames = edit.op == EditOp::kJoin ||
                           edit.op == EditOp::kCut || edit.op == EditOp::kSwap;
      const auto is_shortened = [&](TrackId id) {
        return people.count(id) > 0;
      };
      if (edit.op == EditOp::kDelete) {
        people.insert(edit.persons.front());
      } else if (renames && std::any_of(edit.persons.begin(),
                                        edit.persons.end(), is_shortened)) {
        people.insert(edit.persons.begin(), edit.persons.end());
      }
    }
    return people;
  }

  std::vector<TrackFrame> RunSecondPass() {
    const std::unique_ptr<DetectionSource> source =
        reopen_ ? reopen_() : nullptr;
    if (notes_ != nullptr) notes_->BeginPass();
    SecondPass second(model_, detections_.skeleton, options_.tracker,
                      second_pass_estimator_);
    if (!options_.tracker.life.independent_frames) {
      second.ExtendEnds(first_pass_, Shortened());
    }
    DetectionFrame frame;
    for (size_t i = 0; i < first_pass_.size(); ++i) {
      if (!NextAgain(source.get(), i, &frame) ||
          frame.frame != first_pass_[i].frame) {
        throw std::runtime_error("the detections changed between two passes");
      }
      second.Process(frame, std::move(first_pass_[i]));
    }
    first_pass_ = std::vector<TrackFrame>();
    return second.Finish(request_.threads);
  }

  std::vector<TrackFrame> Count(std::vector<TrackFrame> frames) {
    for (TrackFrame& frame : frames) {
      clock_.Leave(&frame);
      frame = scale_.IntoWorld(std::move(frame));
      check_.Require(scene_.header, frame);
      ++summary_.frames;
      summary_.person_frames += static_cast<int64_t>(frame.people.size());
      for (const PersonPose& person : frame.people) people_.insert(person.id);
    }
    summary_.people = static_cast<int64_t>(people_.size());
    const GraphOptions& graph = options_.estimators.graph;
    if (graph.ledger == nullptr) return frames;
    summary_.solves = graph.ledger->Total();
    if (summary_.solves.solves > 0) summary_.solver = ToString(graph.solver);
    return frames;
  }

  RunOptions options_;  // in the run's metres (Session::scale)
  const RunRequest request_;
  const RunScene scene_;
  const DetectionHeader detections_;
  const PoseCheck check_{scene_.model.cameras};
  RecordingClock clock_;
  RecordingClock clock_again_ = clock_;  // for the second pass
  const SourceOpener reopen_;
  const MakeEstimatorPair make_estimators_;
  SubjectGauge gauge_;
  SubjectScale scale_;
  bool settled_ = false;         // whether the scale is final
  std::deque<Waiting> waiting_;  // frames until then
  SceneModel model_;             // in the run's metres
  std::shared_ptr<RecordingNotes> notes_;
  EstimatorFactory second_pass_estimator_;
  std::optional<Tracker> tracker_;
  StageTimes* stage_times_ = nullptr;
  std::function<void(const DetectionFrame&)> frame_listener_;
  std::function<void(int64_t)> progress_;

  std::atomic<bool> taken_{false};
  const char* unusable_ = nullptr;  // why no frame is accepted, if so
  bool started_ = false;
  int64_t first_frame_ = 0;  // the first frame to be written
  int64_t frames_read_ = 0;
  DetectionFrame used_;               // the frame with the used views only
  std::vector<TrackFrame> finished_;  // from the tracker, to be collected
  std::vector<TrackFrame> first_pass_;
  std::vector<DetectionFrame> kept_;  // for the second pass
  std::vector<IdentityEdit> edits_;
  std::vector<std::string> left_out_;  // by the linking
  RunSummary summary_;
  std::set<TrackId> people_;
};

Session::Session(const RunOptions& options, const RunRequest& request,
                 const DetectionHeader& detections, SourceOpener reopen) {
  impl_ = std::make_unique<Impl>(
      WithLedger(options), request, detections,
      [](const RunOptions& used) { return MakeEstimators(used.estimators); },
      std::move(reopen));
}

Session::Session(const RunOptions& options, const RunRequest& request,
                 const DetectionHeader& detections, EstimatorPair estimators,
                 SourceOpener reopen)
    : impl_(std::make_unique<Impl>(
          options, request, detections,
          [estimators](const RunOptions&) { return estimators; },
          std::move(reopen))) {}

Session::~Session() = default;

const RunScene& Session::scene() const { return impl_->scene_; }
const RunSummary& Session::summary() const { return impl_->summary_; }
const SubjectScale& Session::scale() const { return impl_->scale_; }
const std::vector<IdentityEdit>& Session::identity_edits() const {
  return impl_->edits_;
}
const std::vector<std::string>& Session::linking_left_out() const {
  return impl_->left_out_;
}
LearntNoise Session::learnt_noise() const {
  return impl_->notes_ == nullptr
             ? LearntNoise()
             : impl_->scale_.IntoWorld(impl_->notes_->Noise());
}
ViewBias Session::view_bias() const {
  const RecordingNotes* notes = impl_->notes_.get();
  return notes == nullptr || notes->view_bias() == nullptr
             ? ViewBias()
             : impl_->scale_.IntoWorld(*notes->view_bias());
}

void Session::set_stage_times(StageTimes* times) {
  impl_->stage_times_ = times;
  impl_->tracker_->set_stage_times(times);
}
void Session::set_frame_listener(
    std::function<void(const DetectionFrame&)> listener) {
  impl_->frame_listener_ = std::move(listener);
}
void Session::set_progress(std::function<void(int64_t)> progress) {
  impl_->progress_ = std::move(progress);
}

std::vector<TrackFrame> Session::Process(const DetectionFrame& frame) {
  DetectionFrame copy = frame;
  return impl_->Process(&copy);
}
std::vector<TrackFrame> Session::Process(DetectionFrame&& frame) {
  return impl_->Process(&frame);
}
bool Session::IsPastEnd(int64_t frame) const {
  return IsPast(impl_->request_, frame);
}
std::vector<TrackFrame> Session::Finish() { return impl_->Finish(); }

}  // namespace kinegraph
