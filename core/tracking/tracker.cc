#include "core/tracking/tracker.h"

#include <time.h>  // clock_gettime

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/tracking/track_ends.h"

namespace kinegraph {
namespace {

// Processor time of this thread: what other programs do does not count.
int64_t NowNs() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

// Adds the time until it dies to a stage; without stage times does nothing.
class StageTimer {
 public:
  StageTimer(StageTimes* times, int64_t StageTimes::*stage)
      : total_(times == nullptr ? nullptr : &(times->*stage)),
        start_(total_ == nullptr ? 0 : NowNs()) {}
  ~StageTimer() {
    if (total_ != nullptr) *total_ += NowNs() - start_;
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
      matches_(scene_.cameras.size()) {}

Tracker::~Tracker() = default;

void Tracker::Process(const DetectionFrame& frame,
                      std::vector<TrackFrame>* finished) {
  CheckFrame(frame);
  last_frame_ = frame.frame;
  last_time_ = frame.time;
  ForgetStale(frame.time);
  Prepare(frame);
  Associate(frame);
  Reconstruct(frame);
  Estimate();
  StepLives(frame.time);
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
    track->life.BeginFrame(time);
    any = any || track->life.state() == TrackState::kDeleted;
  }
  if (any) HandOver(Leaving::kEnded);
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
    const Span<Observation> observations = observations_.OfView(v);
    if (cross_view_) SetLastSeen(frame, static_cast<int>(v));
    matcher_.Match(targets_, observations, scene_.cameras[v], &matches_[v]);
    unmatched_[v].clear();
    for (const Observation& observation : observations) {
      unmatched_[v].push_back(&observation);
    }
    for (size_t t = 0; t < tracks_.size(); ++t) {
      const int match = matches_[v][t];
      if (match < 0) continue;
      // The detection leaves the pool and is remembered also if the update
      // then fails.
      tracks_[t]->matched = true;
      tracks_[t]->memory.Store(observations[match], frame.time);
      unmatched_[v][match] = nullptr;
      if (!cross_view_ || !options_.reconstruction.incremental) continue;
      UpdateExpected(tracks_[t].get(), frame.time);
      targets_[t].expected_age_frames = 0.0;
    }
    unmatched_[v].erase(
        std::remove(unmatched_[v].begin(), unmatched_[v].end(), nullptr),
        unmatched_[v].end());
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

void Tracker::StepLives(TimeNs time) {
  for (const auto& track : tracks_) {
    const bool updated = track->frame.has_initial;
    track->life.Step(time, track->matched, updated);
    track->gate.Step(time, track->life.state(), updated);
  }
}

void Tracker::StartNewPeople(const DetectionFrame& frame) {
  const StageTimer timer(stage_times_, &StageTimes::initialisation_ns);
  initialiser_.Run(unmatched_, &new_people_);
  assembler_.BeginFrame(frame.frame, frame.time);
  for (size_t t = 0; t < tracks_.size(); ++t) assembler_.Join();
  for (const NewPerson& person : new_people_) {
    if (!IsTracked(person)) StartTrack(person, frame);
  }
}

// Whether the views that nobody took show somebody whom other views show where
// they are tracked: then nobody new has come.
bool Tracker::IsTracked(const NewPerson& person) const {
  // Both are of this frame and differ by errors of triangulation. At 0.3 m a
  // track that has gone astray kept the one it stood on from a track of their
  // own.
  constexpr double kOnePersonM = 0.2;
  if (options_.life.found_twice == FoundTwice::kKept) return false;
  return std::any_of(tracks_.begin(), tracks_.end(), [&](const auto& track) {
    return track->frame.has_initial &&
           AtOnePlace(person.reconstruction.pose, track->frame.initial,
                      kOnePersonM);
  });
}

void Tracker::StartTrack(const NewPerson& person, const DetectionFrame& frame) {
  auto track = std::make_unique<Track>(
      TrackId(next_id_++), TrackLife(options_.life, clock_, frame.time),
      WriteGate(options_.life, clock_), memory_depth_);
  // The whole 2D poses are remembered, joints the filter removed included.
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
