#include "core/tracking/tracker.h"

#include <glog/logging.h>

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/system/process.h"

namespace kinegraph {

void FrameAssembler::BeginFrame(int64_t frame, TimeNs time) {
  CHECK(open_.empty() || open_.back().content.frame < frame);
  OpenFrame& opened = open_.emplace_back();
  opened.content.frame = frame;
  opened.content.time = time;
}

void FrameAssembler::Resolve(int64_t frame, PersonPose* person) {
  const auto at = std::lower_bound(
      open_.begin(), open_.end(), frame,
      [](const OpenFrame& o, int64_t f) { return o.content.frame < f; });
  CHECK(at != open_.end() && at->content.frame == frame && at->waiting > 0);
  --at->waiting;
  if (person != nullptr) at->content.people.push_back(std::move(*person));
}

void FrameAssembler::ExtractComplete(std::vector<TrackFrame>* frames) {
  while (!open_.empty() && open_.front().waiting == 0) {
    TrackFrame& frame = open_.front().content;
    std::sort(
        frame.people.begin(), frame.people.end(),
        [](const PersonPose& a, const PersonPose& b) { return a.id < b.id; });
    frames->push_back(std::move(frame));
    open_.pop_front();
  }
}

namespace {

// Adds the thread's processor time during its lifetime to a stage; does nothing
// if `times` is null.
class StageTimer {
 public:
  StageTimer(StageTimes* times, int64_t StageTimes::*stage)
      : total_(times == nullptr ? nullptr : &(times->*stage)),
        start_(total_ == nullptr ? 0 : ThreadCpuNs()) {}
  ~StageTimer() {
    if (total_ != nullptr) *total_ += ThreadCpuNs() - start_;
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  int64_t* total_;
  int64_t start_;
};

const TrackerOptions& Checked(const TrackerOptions& options) {
  CheckOptions(options);
  return options;
}

SceneModel Checked(SceneModel scene) {
  if (scene.cameras.empty()) {
    throw OptionError("cameras", "a scene needs at least one camera");
  }
  if (!(scene.frame_rate_hz > 0.0)) {
    throw OptionError("input.frame_rate",
                      "not given, and no file specifies it");
  }
  const Limits sensible = Between(1e-3, 1e5);  // from time-lapse to high speed
  if (!sensible.Contains(scene.frame_rate_hz)) {
    throw OptionError("input.frame_rate",
                      "found " + std::to_string(scene.frame_rate_hz) +
                          " Hz, allowed " + sensible.ToString());
  }
  return scene;
}

// Options that accept a person with few visible joints.
InitialisationOptions OfFewJoints(InitialisationOptions options) {
  options.min_common_joints =
      std::min(options.min_common_joints, kFewestJoints);
  options.min_joints = std::min(options.min_joints, kFewestJoints);
  return options;
}

}  // namespace

Tracker::Tracker(SceneModel scene, const Skeleton& detection_skeleton,
                 const TrackerOptions& options, EstimatorFactory feedback,
                 EstimatorFactory output)
    : scene_(Checked(std::move(scene))),
      options_(WithScaledGates(Checked(options).At(scene_.frame_rate_hz),
                               scene_.cameras, scene_.frame_rate_hz)),
      make_feedback_(std::move(feedback)),
      make_output_(std::move(output)),
      clock_(scene_.frame_rate_hz),
      goes_by_looks_(options.life.in_seconds),
      rhythm_(clock_),
      epipolar_(scene_.cameras),
      observations_(scene_.cameras, detection_skeleton, scene_.skeleton,
                    options_.life.min_found_joints,
                    options_.suppresses_duplicates()),
      matcher_(options_.association, scene_.skeleton.association_joints()),
      evidence_(scene_, epipolar_, options_),
      initialiser_(options_.initialisation, epipolar_,
                   &evidence_.reconstructor(),
                   scene_.skeleton.association_joints()),
      slight_initialiser_(OfFewJoints(options_.initialisation), epipolar_,
                          &evidence_.reconstructor(),
                          scene_.skeleton.association_joints()),
      cross_view_(options_.association.affinity == AffinityKind::kCrossView),
      memory_depth_(MemoryDepth(options_.reconstruction)),
      unmatched_(scene_.cameras.size()),
      matches_(scene_.cameras.size()),
      state_{scene_,        clock_,
             rhythm_,       last_time_,
             observations_, tracks_,
             matches_,      options_.initialisation.alpha_filter_px},
      policy_(MakeAssociationPolicy(options_.rules, state_)) {
  if (options_.rules == AssociationRules::kGraph &&
      AllViewMatcher::AppliesTo(scene_.skeleton)) {
    all_views_.emplace(scene_.cameras, scene_.skeleton.association_joints(),
                       options_.gates.detector_px);
  }
}

Tracker::~Tracker() = default;

void Tracker::Process(const DetectionFrame& frame,
                      std::vector<TrackFrame>* finished) {
  CheckFrame(frame);
  last_frame_ = frame.frame;
  last_time_ = frame.time;
  const bool is_look = !goes_by_looks_ || rhythm_.IsLook(frame);
  ForgetStale(frame.time);
  {
    const StageTimer timer(stage_times_, &StageTimes::preparation_ns);
    observations_.Prepare(frame);
  }
  Associate(frame);
  Reconstruct(frame);
  FindNewPeople(frame);
  policy_->LearnUpdates();
  Estimate();
  StepLives(frame.time, is_look);
  StartNewPeople(frame);
  const StageTimer timer(stage_times_, &StageTimes::output_ns);
  HandOver(Leaving::kEnded);
  assembler_.ExtractComplete(finished);
}

void Tracker::CheckFrame(const DetectionFrame& frame) const {
  const std::string name = "frame " + std::to_string(frame.frame);
  if (!last_frame_.has_value()) return;
  if (frame.frame <= *last_frame_) {
    throw InputError(name + " comes after frame " +
                     std::to_string(*last_frame_) +
                     ", expected frames to ascend");
  }
  if (frame.time <= last_time_) {
    throw InputError(name + ": found a time of " +
                     std::to_string(ToSeconds(frame.time)) + " s after " +
                     std::to_string(ToSeconds(last_time_)) +
                     " s, expected times to ascend");
  }
}

// Removes tracks that are too old to be matched in a frame at `time`.
void Tracker::ForgetStale(TimeNs time) {
  bool any = false;
  for (const auto& track : tracks_) {
    track->life.BeginFrame(time, rhythm_.usual_frames());
    any = any || track->life.state() == TrackState::kDeleted;
  }
  if (any) HandOver(Leaving::kEnded);
}

void Tracker::StartAnew() {
  HandOver(Leaving::kEverybody);
  policy_->StartAnew();
  rhythm_ = LookRhythm(clock_);
}

void Tracker::SetTargets(const DetectionFrame& frame) {
  targets_.clear();
  for (const auto& track : tracks_) {
    track->matched = false;
    AssociationTarget& target = targets_.emplace_back();
    target.pose = &track->feedback->Last();
    target.age_frames = clock_.Frames(frame.time - track->feedback->LastTime());
    if (!cross_view_) {
      // The matching of all views accounts for the growing uncertainty of the
      // prediction (ExpectedSigma), so it predicts for longer.
      const double horizon_s =
          all_views_.has_value() ? kSpeedLasts : options_.association.horizon_s;
      if (!(horizon_s > 0.0)) continue;
      ExpectBody(*track->feedback, frame.time, horizon_s, &track->expected);
      target.pose = &track->expected;
      continue;
    }
    track->feedback->Predict(frame.time, &track->expected);
    target.expected = &track->expected;
    target.expected_age_frames = target.age_frames;
    target.last_seen = &track->last_seen;
  }
}

// Sets each track's joints to those last matched in the view.
void Tracker::SetLastSeen(int view_idx, TimeNs time) {
  for (const auto& track : tracks_) {
    track->last_seen.assign(scene_.skeleton.joint_count(), LastSeenJoint());
    for (const ViewMemory::Entry& entry : track->memory.entries()) {
      if (entry.observation.view_idx != view_idx) continue;
      const double age_frames = clock_.Frames(time - entry.frame_time);
      for (size_t j = 0; j < track->last_seen.size(); ++j) {
        const Keypoint& joint = entry.observation.joints[j];
        if (track->last_seen[j].valid || !joint.found) continue;
        track->last_seen[j] = {true, joint.px, age_frames};
      }
    }
  }
}

void Tracker::Associate(const DetectionFrame& frame) {
  const StageTimer timer(stage_times_, &StageTimes::association_ns);
  SetTargets(frame);
  if (all_views_.has_value()) {
    MatchAllViews(frame.time);
    CollectUnmatched();
    return;
  }
  for (size_t v = 0; v < observations_.view_count(); ++v) {
    matches_[v].assign(tracks_.size(), -1);
    policy_->Forbid(v, &forbidden_);
    MatchView(v, frame.time);
  }
  for (size_t v = 0; v < observations_.view_count(); ++v) {
    if (policy_->MatchesAgain(v, &forbidden_)) MatchView(v, frame.time);
  }
  CollectUnmatched();
}

// Eq. 1: computes the affinities of all tracks with the detections of the view,
// and the assignment with the largest total.
void Tracker::MatchView(size_t view_idx, TimeNs time) {
  if (cross_view_) SetLastSeen(static_cast<int>(view_idx), time);
  matcher_.Match(targets_, observations_.OfView(view_idx),
                 scene_.cameras[view_idx], forbidden_, &view_match_);
  for (size_t t = 0; t < tracks_.size(); ++t) {
    const int match = view_match_[t];
    if (match >= 0) Assign(view_idx, static_cast<size_t>(match), t, time);
  }
}

void Tracker::MatchAllViews(TimeNs time) {
  std::vector<ExpectedPerson> people;
  for (size_t t = 0; t < tracks_.size(); ++t) {
    const double age_s = ToSeconds(time - tracks_[t]->feedback->LastTime());
    people.push_back({targets_[t].pose, ExpectedSigma(age_s)});
  }
  std::vector<Span<Observation>> views;
  std::vector<std::vector<char>> barred(observations_.view_count());
  for (size_t v = 0; v < observations_.view_count(); ++v) {
    views.push_back(observations_.OfView(v));
    policy_->Forbid(v, &barred[v]);
  }
  std::vector<std::vector<int>> matches;
  all_views_->Match(people, views, barred, &matches);
  for (size_t v = 0; v < matches.size(); ++v) {
    matches_[v].assign(tracks_.size(), -1);
    for (size_t t = 0; t < tracks_.size(); ++t) {
      if (matches[v][t] < 0) continue;
      Assign(v, static_cast<size_t>(matches[v][t]), t, time);
    }
  }
}

// The detection counts as matched and is stored even if the update fails later.
void Tracker::Assign(size_t view_idx, size_t observation_idx, size_t target,
                     TimeNs time) {
  Track& track = *tracks_[target];
  track.matched = true;
  track.memory.Store(observations_.OfView(view_idx)[observation_idx], time);
  matches_[view_idx][target] = static_cast<int>(observation_idx);
  if (!cross_view_ || !options_.reconstruction.incremental) return;
  // The expected pose now includes the view that was just matched.
  evidence_.TryUpdate(evidence_.YoungViews(track.memory, time), track.expected);
  track.expected = evidence_.reconstruction().pose;
  targets_[target].expected_age_frames = 0.0;
}

void Tracker::CollectUnmatched() {
  std::vector<char> taken;
  for (size_t v = 0; v < observations_.view_count(); ++v) {
    const Span<Observation> observations = observations_.OfView(v);
    taken.assign(observations.size(), 0);
    for (const int match : matches_[v]) {
      if (match >= 0) taken[match] = 1;
    }
    unmatched_[v].clear();
    for (size_t k = 0; k < observations.size(); ++k) {
      if (!taken[k]) unmatched_[v].push_back(&observations[k]);
    }
  }
}

// Eq. 2 and 3, then DLT, for the tracks that were matched in any view.
void Tracker::Reconstruct(const DetectionFrame& frame) {
  const StageTimer timer(stage_times_, &StageTimes::reconstruction_ns);
  for (const auto& track : tracks_) {
    evidence_.Begin(frame.frame, frame.time, &track->frame);
    if (!track->matched) continue;
    track->feedback->Predict(frame.time, &predicted_);
    evidence_.Update(evidence_.YoungViews(track->memory, frame.time),
                     predicted_, &track->frame);
  }
}

void Tracker::Estimate() {
  const StageTimer timer(stage_times_, &StageTimes::estimation_ns);
  ParallelFor(threads_, static_cast<int>(tracks_.size()), [&](int t) {
    Track& track = *tracks_[t];
    track.feedback->Add(track.frame);
    if (track.output != nullptr) track.output->Add(track.frame);
  });
}

void Tracker::StepLives(TimeNs time, bool is_look) {
  const bool counts_time = options_.life.confirm_s > 0.0;
  const double look_frames = counts_time ? rhythm_.newest_frames() : 1.0;
  for (const auto& track : tracks_) {
    const bool updated = track->frame.has_initial;
    if (is_look) {
      track->life.Step(time, track->matched, updated && policy_->Counts(*track),
                       look_frames);
    }
    track->gate.Step(time, track->life.state(), updated);
  }
}

// Algorithm 2, on the unmatched detections.
void Tracker::FindNewPeople(const DetectionFrame& frame) {
  const StageTimer timer(stage_times_, &StageTimes::initialisation_ns);
  initialiser_.Run(unmatched_, &new_people_);
  bool withdrawn = false;
  for (const NewPerson& person : new_people_) {
    const std::optional<size_t> track = policy_->FalseRecovery(person);
    if (!track.has_value()) continue;
    Withdraw(*track, frame);
    withdrawn = true;
  }
  if (withdrawn) {
    CollectUnmatched();
    initialiser_.Run(unmatched_, &new_people_);
  }
  if (policy_->AwaitsSlight()) FindSlightPeople();
}

// Algorithm 2 with fewer joints, on the detections left by FindNewPeople.
void Tracker::FindSlightPeople() {
  for (const NewPerson& person : new_people_) {
    for (const Observation* member : person.members) {
      ObservationGroup& left = unmatched_[member->view_idx];
      left.erase(std::find(left.begin(), left.end(), member));
    }
  }
  slight_initialiser_.Run(unmatched_, &slight_people_);
  policy_->SeeSlight(&slight_people_);
  for (NewPerson& person : slight_people_) {
    new_people_.push_back(std::move(person));
  }
}

// Undoes the track's matches of this frame and ends it.
void Tracker::Withdraw(size_t target, const DetectionFrame& frame) {
  Track& track = *tracks_[target];
  for (std::vector<int>& matches : matches_) matches[target] = -1;
  evidence_.Begin(frame.frame, frame.time, &track.frame);
  track.matched = false;
  track.life.End();
}

void Tracker::StartNewPeople(const DetectionFrame& frame) {
  const StageTimer timer(stage_times_, &StageTimes::initialisation_ns);
  assembler_.BeginFrame(frame.frame, frame.time);
  for (size_t t = 0; t < tracks_.size(); ++t) assembler_.Join();
  for (const NewPerson& person : new_people_) {
    if (policy_->MayBegin(person)) StartTrack(person, frame);
  }
}

void Tracker::StartTrack(const NewPerson& person, const DetectionFrame& frame) {
  auto track = std::make_unique<Track>(
      TrackId(next_id_++), TrackLife(options_.life, clock_, frame.time),
      WriteGate(options_.life, clock_), memory_depth_);
  policy_->LearnBeginning(person, track->id);
  // Whole 2D poses are stored, including joints that the filter removed.
  std::vector<UsedView> views;
  for (const Observation* member : person.members) {
    track->memory.Store(*member, frame.time);
    views.push_back({member, 0.0});
  }
  EstimatorFrame& work = track->frame;
  evidence_.Begin(frame.frame, frame.time, &work);
  FillEstimatorFrame(views, person.reconstruction, /*succeeded=*/true, &work);
  track->feedback = make_feedback_(scene_);
  track->feedback->Add(work);
  if (make_output_ != nullptr) {
    track->output = make_output_(scene_);
    track->output->Add(work);
  }
  track->gate.Step(frame.time, track->life.state(), /*updated=*/true);
  assembler_.Join();
  tracks_.push_back(std::move(track));
}

// Passes final poses to the assembler and removes tracks that have ended, or
// all tracks.
void Tracker::HandOver(Leaving leaving) {
  const auto ends = [&](const Track& track) {
    return leaving == Leaving::kEverybody ||
           track.life.state() == TrackState::kDeleted;
  };
  ParallelFor(threads_, static_cast<int>(tracks_.size()), [&](int t) {
    if (ends(*tracks_[t])) tracks_[t]->writer().Finish();
  });
  for (const auto& track : tracks_) {
    if (ends(*track)) track->gate.Close();
    HandOverFinals(track.get());
  }
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(),
                               [&](const auto& track) { return ends(*track); }),
                tracks_.end());
}

void Tracker::HandOverFinals(Track* track) {
  if (track->output != nullptr) {
    // The feedback's final poses are not written, but would accumulate.
    finals_.clear();
    track->feedback->ExtractFinals(&finals_);
  }
  finals_.clear();
  track->writer().ExtractFinals(&finals_);
  for (FinalPose& final_pose : finals_) {
    track->finals.push_back(std::move(final_pose));
  }
  bool write = false;
  while (!track->finals.empty() && track->gate.Pop(&write)) {
    FinalPose& oldest = track->finals.front();
    write = write && CountPresent(oldest.person.joints) > 0;
    oldest.person.id = track->id;
    assembler_.Resolve(oldest.frame, write ? &oldest.person : nullptr);
    track->finals.pop_front();
  }
}

void Tracker::Finish(std::vector<TrackFrame>* finished) {
  HandOver(Leaving::kEverybody);
  assembler_.ExtractComplete(finished);
}

}  // namespace kinegraph
