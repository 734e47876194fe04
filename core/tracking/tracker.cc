#include "core/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/system/clock.h"
#include "core/tracking/track_ends.h"

namespace kinegraph {
namespace {

// Adds the time until it dies to a stage; without stage times does nothing.
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

// Views of this frame whose joints the filter kept, most of them.
std::vector<int> AgreeingViews(const EstimatorFrame& frame) {
  std::vector<int> views;
  if (!frame.has_initial) return views;
  for (const FreshView& view : frame.views) {
    int kept = 0;
    int removed = 0;
    for (const FilterVerdict verdict : view.verdicts) {
      kept += verdict == FilterVerdict::kKept;
      removed += verdict == FilterVerdict::kRemoved;
    }
    if (kept > removed) views.push_back(view.view_idx);
  }
  return views;
}

SceneModel Checked(SceneModel scene) {
  if (scene.cameras.empty()) {
    throw OptionError("cameras", "a scene needs at least one camera");
  }
  if (!(scene.frame_rate_hz > 0.0)) {
    throw OptionError("input.frame_rate", "not given, and no file tells it");
  }
  const Limits sensible = Between(1e-3, 1e5);  // time-lapse to high speed
  if (!sensible.Contains(scene.frame_rate_hz)) {
    throw OptionError("input.frame_rate",
                      "found " + std::to_string(scene.frame_rate_hz) +
                          " Hz, allowed " + sensible.ToString());
  }
  return scene;
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
                    options_.life.min_found_joints, options_.life.found_twice),
      matcher_(options_.association, scene_.skeleton.association_joints()),
      evidence_(scene_, epipolar_, options_),
      initialiser_(options_.initialisation, epipolar_,
                   &evidence_.reconstructor(),
                   scene_.skeleton.association_joints()),
      cross_view_(options_.association.affinity == AffinityKind::kCrossView),
      memory_depth_(
          options_.reconstruction.newest == NewestRule::kJoint
              ? static_cast<int>(std::ceil(options_.reconstruction.tau_frames))
              : 1),
      unmatched_(scene_.cameras.size()),
      matches_(scene_.cameras.size()) {
  ForgetStrands();
}

Tracker::~Tracker() = default;

void Tracker::Process(const DetectionFrame& frame,
                      std::vector<TrackFrame>* finished) {
  CheckFrame(frame);
  last_frame_ = frame.frame;
  last_time_ = frame.time;
  const bool is_look = !goes_by_looks_ || rhythm_.IsLook(frame);
  ForgetStale(frame.time);
  Prepare(frame);
  Associate(frame);
  Reconstruct(frame);
  FindNewPeople(frame);
  if (HoldsStrands()) ClaimStrands();
  Estimate();
  StepLives(frame.time, is_look);
  StartNewPeople(frame);
  const StageTimer timer(stage_times_, &StageTimes::output_ns);
  HandOver(Leaving::kEnded);
  assembler_.TakeComplete(finished);
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

// Parts with tracks that are too old to be matched in a frame at `time`.
void Tracker::ForgetStale(TimeNs time) {
  bool any = false;
  for (const auto& track : tracks_) {
    track->life.BeginFrame(time, rhythm_.usual_frames());
    any = any || track->life.state() == TrackState::kDeleted;
  }
  if (any) HandOver(Leaving::kEnded);
}

void Tracker::ForgetStrands() {
  if (options_.life.found_twice == FoundTwice::kKept) return;
  strands_.assign(scene_.cameras.size(),
                  ViewStrands(scene_.skeleton.association_joints()));
}

void Tracker::StartAnew() {
  HandOver(Leaving::kEverybody);
  ForgetStrands();
  rhythm_ = LookRhythm(clock_);
}

void Tracker::Prepare(const DetectionFrame& frame) {
  const StageTimer timer(stage_times_, &StageTimes::preparation_ns);
  observations_.Prepare(frame);
}

void Tracker::SetTargets(const DetectionFrame& frame) {
  targets_.clear();
  for (const auto& track : tracks_) {
    track->matched = false;
    AssociationTarget& target = targets_.emplace_back();
    target.pose = &track->feedback->Last();
    target.age_frames = clock_.Frames(frame.time - track->feedback->LastTime());
    if (!cross_view_) {
      const double horizon_s = options_.association.horizon_s;
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

// What each track last had in a view, joint by joint.
void Tracker::SetLastSeen(const DetectionFrame& frame, int view_idx) {
  for (const auto& track : tracks_) {
    track->last_seen.assign(scene_.skeleton.joint_count(), LastSeenJoint());
    for (const ViewMemory::Entry& entry : track->memory.entries()) {
      if (entry.observation.view_idx != view_idx) continue;
      const double age_frames = clock_.Frames(frame.time - entry.frame_time);
      for (size_t j = 0; j < track->last_seen.size(); ++j) {
        const Keypoint& joint = entry.observation.joints[j];
        if (track->last_seen[j].valid || !joint.found) continue;
        track->last_seen[j] = {true, joint.px, age_frames};
      }
    }
  }
}

// The track's expected pose with the view that was matched just now.
void Tracker::UpdateExpected(Track* track, TimeNs time) {
  evidence_.Look(evidence_.YoungViews(track->memory, time), track->expected);
  track->expected = evidence_.reconstruction().pose;
}

void Tracker::Associate(const DetectionFrame& frame) {
  const StageTimer timer(stage_times_, &StageTimes::association_ns);
  SetTargets(frame);
  for (size_t v = 0; v < observations_.view_count(); ++v) {
    if (cross_view_) SetLastSeen(frame, static_cast<int>(v));
    AssociateView(v, frame.time);
  }
  for (size_t v = 0; v < observations_.view_count(); ++v) {
    if (HoldsStrands()) TakeWhatIsLeft(v, frame.time);
    unmatched_[v].erase(
        std::remove(unmatched_[v].begin(), unmatched_[v].end(), nullptr),
        unmatched_[v].end());
  }
}

// By the frames before this one, until lives are stepped.
bool Tracker::IsLost(const Track& track) const {
  constexpr double kLost = 0.1;  // s without an update, and a look or more
  const TimeNs age = last_time_ - track.life.last_update();
  return ToSeconds(age) > kLost &&
         !clock_.Less(age, 1.0 + rhythm_.usual_frames());
}

// The track from whose detections one goes on, if that track is lost by now. Of
// those who are there their poses tell better than one view does.
std::optional<TrackId> Tracker::LostHolder(size_t view_idx,
                                           size_t observation_idx) const {
  const std::optional<TrackId> holder =
      strands_[view_idx].HolderOf(observation_idx);
  if (!holder.has_value()) return std::nullopt;
  const bool there =
      std::any_of(tracks_.begin(), tracks_.end(), [&](const auto& track) {
        return track->id == *holder && !IsLost(*track);
      });
  return there ? std::nullopt : holder;
}

bool Tracker::IsOfSomebodyLost(size_t view_idx, size_t observation_idx,
                               TrackId but) const {
  const std::optional<TrackId> holder = LostHolder(view_idx, observation_idx);
  return holder.has_value() && *holder != but;
}

// Nobody takes a detection of somebody lost.
void Tracker::AssociateView(size_t view_idx, TimeNs time) {
  const Span<Observation> observations = observations_.OfView(view_idx);
  barred_.clear();
  if (HoldsStrands()) {
    strands_[view_idx].Follow(observations, time);
    for (const auto& track : tracks_) {
      for (size_t k = 0; k < observations.size(); ++k) {
        barred_.push_back(IsOfSomebodyLost(view_idx, k, track->id));
      }
    }
  }
  matcher_.Match(targets_, observations, scene_.cameras[view_idx], barred_,
                 &matches_[view_idx]);
  unmatched_[view_idx].clear();
  for (const Observation& observation : observations) {
    unmatched_[view_idx].push_back(&observation);
  }
  for (size_t t = 0; t < tracks_.size(); ++t) {
    const int match = matches_[view_idx][t];
    if (match >= 0) Give(view_idx, static_cast<size_t>(match), t, time);
  }
}

// Whom two other views have needs no protection from a detection that another
// held and nobody took: they say where the person is, whatever it shows.
void Tracker::TakeWhatIsLeft(size_t view_idx, TimeNs time) {
  constexpr int kSure = 2;  // views
  const Span<Observation> observations = observations_.OfView(view_idx);
  barred_.assign(tracks_.size() * observations.size(), 1);
  bool any = false;
  for (size_t t = 0; t < tracks_.size(); ++t) {
    if (matches_[view_idx][t] >= 0) continue;
    int views = 0;
    for (const std::vector<int>& matches : matches_) views += matches[t] >= 0;
    if (views < kSure) continue;
    for (size_t k = 0; k < observations.size(); ++k) {
      if (unmatched_[view_idx][k] == nullptr ||
          !IsOfSomebodyLost(view_idx, k, tracks_[t]->id)) {
        continue;
      }
      barred_[t * observations.size() + k] = 0;
      any = true;
    }
  }
  if (!any) return;
  std::vector<int> left;
  matcher_.Match(targets_, observations, scene_.cameras[view_idx], barred_,
                 &left);
  for (size_t t = 0; t < tracks_.size(); ++t) {
    if (left[t] < 0) continue;
    matches_[view_idx][t] = left[t];
    Give(view_idx, static_cast<size_t>(left[t]), t, time);
  }
}

// The detection leaves the pool and is remembered also if the update then
// fails.
void Tracker::Give(size_t view_idx, size_t observation_idx, size_t target,
                   TimeNs time) {
  Track& track = *tracks_[target];
  track.matched = true;
  track.memory.Store(observations_.OfView(view_idx)[observation_idx], time);
  unmatched_[view_idx][observation_idx] = nullptr;
  if (!cross_view_ || !options_.reconstruction.incremental) return;
  UpdateExpected(&track, time);
  targets_[target].expected_age_frames = 0.0;
}

// Who has two views that agree has a right to their detections.
void Tracker::ClaimStrands() {
  for (size_t t = 0; t < tracks_.size(); ++t) {
    const std::vector<int> views = AgreeingViews(tracks_[t]->frame);
    if (views.size() < 2) continue;
    for (const int v : views) {
      const int match = matches_[static_cast<size_t>(v)][t];
      if (match < 0) continue;
      strands_[static_cast<size_t>(v)].Claim(static_cast<size_t>(match),
                                             tracks_[t]->id);
    }
  }
}

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
    if (is_look) track->life.Step(time, track->matched, updated, look_frames);
    track->gate.Step(time, track->life.state(), updated);
  }
}

// Who was lost and now has some of the views of a person, while the others
// would start somebody new, is as likely another: a track that drifts unseen
// takes who comes back where it happens to be. It ends as it was lost, all
// views start somebody new, and linking tells whether they are the same.
void Tracker::FindNewPeople(const DetectionFrame& frame) {
  const StageTimer timer(stage_times_, &StageTimes::initialisation_ns);
  initialiser_.Run(unmatched_, &new_people_);
  if (options_.life.found_twice == FoundTwice::kKept) return;
  bool taken_back = false;
  for (const NewPerson& person : new_people_) {
    const std::optional<size_t> at = TrackedAt(person);
    if (!at.has_value() || !IsLost(*tracks_[*at])) continue;
    TakeBack(*at, frame);
    taken_back = true;
  }
  if (taken_back) initialiser_.Run(unmatched_, &new_people_);
}

// What the track was given in this frame; its life ends.
void Tracker::TakeBack(size_t target, const DetectionFrame& frame) {
  Track& track = *tracks_[target];
  for (size_t v = 0; v < unmatched_.size(); ++v) {
    int& match = matches_[v][target];
    if (match < 0) continue;
    const Observation* observation =
        &observations_.OfView(v)[static_cast<size_t>(match)];
    ObservationGroup& left = unmatched_[v];
    left.insert(std::upper_bound(left.begin(), left.end(), observation),
                observation);
    match = -1;
  }
  evidence_.Begin(frame.frame, frame.time, &track.frame);
  track.matched = false;
  track.life.End();
}

void Tracker::StartNewPeople(const DetectionFrame& frame) {
  const StageTimer timer(stage_times_, &StageTimes::initialisation_ns);
  assembler_.BeginFrame(frame.frame, frame.time);
  for (size_t t = 0; t < tracks_.size(); ++t) assembler_.Join();
  for (const NewPerson& person : new_people_) {
    if (!TrackedAt(person).has_value() && !IsOfTwo(person)) {
      StartTrack(person, frame);
    }
  }
}

// Whether its views show two people: what they show goes on from what two lost
// tracks held.
bool Tracker::IsOfTwo(const NewPerson& person) const {
  if (!HoldsStrands()) return false;
  std::optional<TrackId> holder;
  for (const Observation* member : person.members) {
    const std::optional<TrackId> one =
        LostHolder(static_cast<size_t>(member->view_idx), IndexOf(*member));
    if (!one.has_value()) continue;
    if (holder.has_value() && *holder != *one) return true;
    holder = one;
  }
  return false;
}

void Tracker::NoteSuccession(const NewPerson& person, TrackId track) {
  if (!HoldsStrands()) return;
  Succession succession;
  succession.to = track;
  for (const Observation* member : person.members) {
    const ViewStrands& strands =
        strands_[static_cast<size_t>(member->view_idx)];
    const std::optional<TrackId> one =
        LostHolder(static_cast<size_t>(member->view_idx), IndexOf(*member));
    if (!one.has_value()) continue;
    const TimeNs since = strands.HeldSince(IndexOf(*member));
    succession.from = *one;
    succession.since =
        succession.views == 0 ? since : std::min(succession.since, since);
    ++succession.views;
  }
  if (succession.views > 0) successions_.push_back(succession);
}

// Within its view and frame.
size_t Tracker::IndexOf(const Observation& observation) const {
  const auto view = static_cast<size_t>(observation.view_idx);
  return static_cast<size_t>(&observation - observations_.OfView(view).data());
}

// The track that other views show where the views that nobody took show this
// person: then nobody new has come.
std::optional<size_t> Tracker::TrackedAt(const NewPerson& person) const {
  // Both are of this frame and differ by errors of triangulation. At 0.3 m a
  // track that has gone astray kept the one it stood on from a track of their
  // own.
  constexpr double kOnePersonM = 0.2;
  if (options_.life.found_twice == FoundTwice::kKept) return std::nullopt;
  for (size_t t = 0; t < tracks_.size(); ++t) {
    const EstimatorFrame& seen = tracks_[t]->frame;
    if (seen.has_initial &&
        SeenAtOnePlace(person.reconstruction.pose, seen.initial, kOnePersonM)) {
      return t;
    }
  }
  return std::nullopt;
}

void Tracker::StartTrack(const NewPerson& person, const DetectionFrame& frame) {
  auto track = std::make_unique<Track>(
      TrackId(next_id_++), TrackLife(options_.life, clock_, frame.time),
      WriteGate(options_.life, clock_), memory_depth_);
  NoteSuccession(person, track->id);
  // The whole 2D poses are remembered, joints the filter removed included.
  std::vector<UsedView> views;
  for (const Observation* member : person.members) {
    track->memory.Store(*member, frame.time);
    if (HoldsStrands()) {
      strands_[static_cast<size_t>(member->view_idx)].Claim(IndexOf(*member),
                                                            track->id);
    }
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

// Hands finals to the assembler, and parts with tracks whose life has ended, or
// with every track.
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
    // Nobody writes the feedback's finals; left alone they would pile up.
    finals_.clear();
    track->feedback->TakeFinals(&finals_);
  }
  finals_.clear();
  track->writer().TakeFinals(&finals_);
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
  assembler_.TakeComplete(finished);
}

}  // namespace kinegraph
