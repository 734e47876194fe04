#include "core/tracking/replay.h"

#include <glog/logging.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/system/process.h"
#include "core/tracking/evidence.h"
#include "core/tracking/frame_observations.h"

namespace kinegraph {

namespace {

// Forwards everything and records which detections were matched.
class FreezingEstimator final : public Estimator {
 public:
  FreezingEstimator(std::unique_ptr<Estimator> estimator,
                    std::shared_ptr<MatchFreezer::Record> record)
      : estimator_(std::move(estimator)), record_(std::move(record)) {}

  void Add(const EstimatorFrame& frame) override {
    FrozenFrame& frozen = record_->emplace_back();
    frozen.frame = frame.frame;
    frozen.time = frame.time;
    for (const FreshView& view : frame.views) {
      frozen.detections.push_back({view.view_idx, view.detection_idx});
    }
    estimator_->Add(frame);
  }
  const Pose3d& Last() const override { return estimator_->Last(); }
  TimeNs LastTime() const override { return estimator_->LastTime(); }
  void Predict(TimeNs time, Pose3d* pose) const override {
    estimator_->Predict(time, pose);
  }
  void ExtractFinals(std::vector<FinalPose>* finals) override {
    estimator_->ExtractFinals(finals);
  }
  void Finish() override { estimator_->Finish(); }

 private:
  std::unique_ptr<Estimator> estimator_;
  std::shared_ptr<MatchFreezer::Record> record_;
};

const Observation& FindObservation(const FrameObservations& observations,
                                   const FrozenDetection& wanted,
                                   int64_t frame) {
  for (const Observation& observation :
       observations.OfView(static_cast<size_t>(wanted.view_idx))) {
    if (observation.detection_idx == wanted.detection_idx) return observation;
  }
  throw InputError("frozen matches: view " + std::to_string(wanted.view_idx) +
                   ", frame " + std::to_string(frame) + ": no detection " +
                   std::to_string(wanted.detection_idx));
}

}  // namespace

EstimatorFactory MatchFreezer::Wrap(EstimatorFactory estimator) {
  return [make = std::move(estimator),
          records = records_](const SceneModel& scene) {
    auto record = std::make_shared<Record>();
    records->push_back(record);
    return std::make_unique<FreezingEstimator>(make(scene), std::move(record));
  };
}

FrozenMatches MatchFreezer::Matches(
    const std::vector<TrackFrame>& tracks) const {
  std::set<std::pair<TrackId, int64_t>> written;
  for (const TrackFrame& frame : tracks) {
    for (const PersonPose& person : frame.people) {
      written.emplace(person.id, frame.frame);
    }
  }
  FrozenMatches matches;
  for (const std::shared_ptr<Record>& record : *records_) {
    FrozenPerson& person = matches.people.emplace_back();
    person.id = TrackId(static_cast<int64_t>(matches.people.size()) - 1);
    person.frames = *record;
    for (FrozenFrame& frame : person.frames) {
      frame.written = written.count({person.id, frame.frame}) > 0;
    }
  }
  return matches;
}

Replay::Replay(SceneModel scene, const DetectionSequence& detections,
               const FrozenMatches& matches, const TrackerOptions& options,
               EstimatorFactory feedback)
    : scene_(std::move(scene)),
      matches_(matches),
      options_(WithScaledGates(options.At(scene_.frame_rate_hz), scene_.cameras,
                               scene_.frame_rate_hz)),
      make_feedback_(std::move(feedback)),
      epipolar_(scene_.cameras) {
  FrameObservations observations(
      scene_.cameras, detections.header.skeleton, scene_.skeleton,
      options_.life.min_found_joints, options_.suppresses_duplicates());
  for (const FrozenPerson& person : matches_.people) {
    seen_.emplace_back(person.frames.size());
  }
  std::vector<size_t> next(seen_.size(), 0);  // one per person
  for (const DetectionFrame& frame : detections.frames) {
    frames_.push_back({frame.frame, frame.time, {}});
    bool is_prepared = false;
    for (size_t p = 0; p < seen_.size(); ++p) {
      const std::vector<FrozenFrame>& frozen = matches_.people[p].frames;
      size_t& k = next[p];
      while (k < frozen.size() && frozen[k].detections.empty()) ++k;
      if (k == frozen.size() || frozen[k].frame != frame.frame) continue;
      if (!is_prepared) observations.Prepare(frame);
      is_prepared = true;
      for (const FrozenDetection& detection : frozen[k].detections) {
        seen_[p][k].push_back(
            FindObservation(observations, detection, frame.frame));
      }
      ++k;
    }
  }
  for (size_t p = 0; p < seen_.size(); ++p) {
    const std::vector<FrozenFrame>& frozen = matches_.people[p].frames;
    size_t k = next[p];
    while (k < frozen.size() && frozen[k].detections.empty()) ++k;
    if (k == frozen.size()) continue;
    throw InputError("frozen matches: frame " +
                     std::to_string(frozen[k].frame) +
                     " is not among the detections");
  }
}

ReplayedPerson Replay::PreparePerson(size_t person_idx,
                                     int without_view) const {
  const FrozenPerson& frozen = matches_.people[person_idx];
  EvidenceStep evidence(scene_, epipolar_, options_);
  std::unique_ptr<Estimator> feedback;
  ViewMemory memory(MemoryDepth(options_.reconstruction));
  std::vector<UsedView> views;
  Pose3d predicted;
  ReplayedPerson person;
  person.id = frozen.id;
  for (size_t k = 0; k < frozen.frames.size(); ++k) {
    const FrozenFrame& frame = frozen.frames[k];
    views.clear();
    for (const Observation& seen : seen_[person_idx][k]) {
      if (seen.view_idx != without_view) views.push_back({&seen, 0.0});
    }
    EstimatorFrame work;
    evidence.Begin(frame.frame, frame.time, &work);
    const bool is_new = feedback == nullptr;
    if (is_new && !evidence.Initialise(views, &work)) continue;
    for (const UsedView& view : views) {
      memory.Store(*view.observation, frame.time);
    }
    if (is_new) {
      feedback = make_feedback_(scene_);
    } else if (!views.empty()) {
      feedback->Predict(frame.time, &predicted);
      evidence.Update(evidence.YoungViews(memory, frame.time), predicted,
                      &work);
    }
    feedback->Add(work);
    person.frames.push_back(std::move(work));
    person.written.push_back(frame.written);
  }
  return person;
}

std::vector<ReplayedPerson> Replay::Prepare(int without_view,
                                            int threads) const {
  std::vector<ReplayedPerson> people(matches_.people.size());
  ParallelFor(threads, static_cast<int>(people.size()), [&](int p) {
    people[p] = PreparePerson(static_cast<size_t>(p), without_view);
  });
  people.erase(std::remove_if(people.begin(), people.end(),
                              [](const ReplayedPerson& person) {
                                return person.frames.empty();
                              }),
               people.end());
  return people;
}

namespace {

// Feeds an estimator the frames of one person; records its final poses,
// processor time and delay.
class RunningEstimator {
 public:
  RunningEstimator(const SceneModel& scene, const EstimatorFactory& estimator) {
    const int64_t start_ns = ThreadCpuNs();
    estimator_ = estimator(scene);
    outcome_.cpu_ns = ThreadCpuNs() - start_ns;
  }

  void Add(const EstimatorFrame& frame) {
    const int64_t start_ns = ThreadCpuNs();
    const size_t before = outcome_.finals.size();
    estimator_->Add(frame);
    estimator_->ExtractFinals(&outcome_.finals);
    outcome_.cpu_ns += ThreadCpuNs() - start_ns;
    if (outcome_.finals.size() == before) return;
    const TimeNs delay = frame.time - outcome_.finals[before].time;
    outcome_.delay = std::max(outcome_.delay.value_or(0), delay);
  }

  ReplayOutcome Finish() {
    const int64_t start_ns = ThreadCpuNs();
    estimator_->Finish();
    estimator_->ExtractFinals(&outcome_.finals);
    estimator_.reset();
    outcome_.cpu_ns += ThreadCpuNs() - start_ns;
    return std::move(outcome_);
  }

 private:
  std::unique_ptr<Estimator> estimator_;
  ReplayOutcome outcome_;
};

}  // namespace

ReplayOutcome RunEstimator(const SceneModel& scene,
                           const ReplayedPerson& person,
                           const EstimatorFactory& estimator) {
  RunningEstimator one(scene, estimator);
  for (const EstimatorFrame& frame : person.frames) one.Add(frame);
  ReplayOutcome outcome = one.Finish();
  CHECK_EQ(outcome.finals.size(), person.frames.size());
  return outcome;
}

std::vector<ReplayOutcome> RunEstimators(
    const SceneModel& scene, const std::vector<ReplayedPerson>& people,
    const EstimatorFactory& estimator) {
  struct Step {
    TimeNs time;
    size_t person, index;
  };
  std::vector<Step> steps;
  for (size_t p = 0; p < people.size(); ++p) {
    for (size_t k = 0; k < people[p].frames.size(); ++k) {
      steps.push_back({people[p].frames[k].time, p, k});
    }
  }
  std::stable_sort(
      steps.begin(), steps.end(),
      [](const Step& a, const Step& b) { return a.time < b.time; });
  std::vector<std::unique_ptr<RunningEstimator>> running(people.size());
  for (const Step& step : steps) {
    auto& one = running[step.person];
    if (one == nullptr) {
      one = std::make_unique<RunningEstimator>(scene, estimator);
    }
    one->Add(people[step.person].frames[step.index]);
  }
  std::vector<ReplayOutcome> outcomes;
  for (size_t p = 0; p < people.size(); ++p) {
    outcomes.push_back(running[p] == nullptr ? ReplayOutcome()
                                             : running[p]->Finish());
    CHECK_EQ(outcomes.back().finals.size(), people[p].frames.size());
  }
  return outcomes;
}

std::vector<TrackFrame> AssembleReplay(
    const std::vector<TrackFrame>& frames,
    const std::vector<ReplayedPerson>& people,
    std::vector<ReplayOutcome> outcomes, int64_t first_frame) {
  std::vector<TrackFrame> assembled;
  for (const TrackFrame& frame : frames) {
    if (frame.frame < first_frame) continue;
    TrackFrame& empty = assembled.emplace_back();
    empty.frame = frame.frame;
    empty.time = frame.time;
  }
  for (size_t p = 0; p < people.size(); ++p) {
    auto at = assembled.begin();
    for (size_t k = 0; k < people[p].frames.size(); ++k) {
      FinalPose& final_pose = outcomes[p].finals[k];
      CHECK_EQ(final_pose.frame, people[p].frames[k].frame);
      if (!people[p].written[k] || final_pose.frame < first_frame) continue;
      if (CountPresent(final_pose.person.joints) == 0) continue;
      at = std::lower_bound(
          at, assembled.end(), final_pose.frame,
          [](const TrackFrame& f, int64_t n) { return f.frame < n; });
      CHECK(at != assembled.end() && at->frame == final_pose.frame);
      final_pose.person.id = people[p].id;
      at->people.push_back(std::move(final_pose.person));
    }
  }
  return assembled;
}

}  // namespace kinegraph
