#include "core/tracking/second_pass.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include "core/base/parallel.h"

namespace kinegraph {
namespace {

constexpr double kVelocitySeconds = 0.2;  // averaging time of an end's velocity
constexpr double kFades = 0.5;            // s, time constant of the velocity
constexpr double kNewShare = 0.3;         // weight of the newest velocity

// A person in one frame.
struct Place {
  int64_t index;  // of the frame
  int64_t frame;
  TimeNs time;
  Eigen::Vector3d centre_m;
};

// Mean displacement of the joints that both poses have.
std::optional<Eigen::Vector3d> Shift(const Pose3d& from, const Pose3d& to) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (size_t j = 0; j < from.size(); ++j) {
    if (!from[j].present() || !to[j].present()) continue;
    sum += to[j].position_m - from[j].position_m;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return Eigen::Vector3d(sum / count);
}

// Velocity at `end`, estimated from there towards the inside of [begin, stop).
Eigen::Vector3d VelocityAt(const std::vector<Place>& places, size_t end,
                           size_t begin, size_t stop) {
  size_t inside = end;
  const auto step = [&](size_t k) { return end == begin ? k + 1 : k - 1; };
  while (inside != (end == begin ? stop - 1 : begin) &&
         std::abs(ToSeconds(places[step(inside)].time - places[end].time)) <=
             kVelocitySeconds) {
    inside = step(inside);
  }
  const double seconds = ToSeconds(places[inside].time - places[end].time);
  if (seconds == 0.0) return Eigen::Vector3d::Zero();
  return (places[inside].centre_m - places[end].centre_m) / seconds;
}

std::vector<TrackRun> RunsOf(const std::vector<Place>& places) {
  std::vector<TrackRun> runs;
  for (size_t begin = 0, stop = 0; begin < places.size(); begin = stop) {
    stop = begin + 1;
    while (stop < places.size() &&
           places[stop].index == places[stop - 1].index + 1) {
      ++stop;
    }
    runs.push_back({places[begin].frame, places[stop - 1].frame,
                    VelocityAt(places, begin, begin, stop),
                    VelocityAt(places, stop - 1, begin, stop)});
  }
  return runs;
}

// Adds the joints of the first pass that the second does not estimate.
void AddMissing(const PersonPose& first, PersonPose* second) {
  for (size_t j = 0; j < second->joints.size(); ++j) {
    if (second->joints[j].present() || !first.joints[j].present()) continue;
    second->joints[j] = first.joints[j];
    second->joints[j].status = JointStatus::kInferred;
    if (j < first.covariances.size() && j < second->covariances.size()) {
      second->covariances[j] = first.covariances[j];
    }
  }
}

}  // namespace

std::map<TrackId, std::vector<TrackRun>> FindRuns(
    const std::vector<TrackFrame>& frames) {
  std::map<TrackId, std::vector<Place>> places;
  for (size_t f = 0; f < frames.size(); ++f) {
    for (const PersonPose& person : frames[f].people) {
      const auto centre = MeanPosition(person.joints);
      if (!centre.has_value()) continue;
      places[person.id].push_back(
          {static_cast<int64_t>(f), frames[f].frame, frames[f].time, *centre});
    }
  }
  std::map<TrackId, std::vector<TrackRun>> runs;
  for (const auto& [id, of_person] : places) runs[id] = RunsOf(of_person);
  return runs;
}

EndFollower::EndFollower(Pose3d pose, TimeNs time, Eigen::Vector3d velocity_mps)
    : pose_(std::move(pose)),
      time_(time),
      velocity_mps_(std::move(velocity_mps)) {}

Pose3d EndFollower::At(TimeNs time) const {
  const double seconds = ToSeconds(time - time_);
  const double moved_s =
      std::copysign(kFades * -std::expm1(-std::abs(seconds) / kFades), seconds);
  Pose3d pose = pose_;
  for (Joint3d& joint : pose) joint.position_m += moved_s * velocity_mps_;
  return pose;
}

void EndFollower::Agree(const Pose3d& pose, TimeNs time) {
  const double seconds = ToSeconds(time - time_);
  const std::optional<Eigen::Vector3d> shift = Shift(pose_, pose);
  if (seconds != 0.0 && shift.has_value()) {
    velocity_mps_ += kNewShare * (*shift / seconds - velocity_mps_);
  }
  pose_ = pose;
  time_ = time;
}

namespace {

// The longest time for which a person is followed back from the first frame of
// a run.
constexpr TimeNs kLongestBack = 2'000'000'000;  // 2 s
// Frames beyond the end of a track that only one view sees, without later ones
// that two views see, are written as long as the root mean square of the
// joints' standard deviations per axis is below this: a third of the distance
// at which two people pass each other.
constexpr double kSureSigma = 0.15;  // m

bool IsSure(const PersonPose& person) {
  double sum_m2 = 0.0;
  int count = 0;
  for (size_t j = 0; j < person.covariances.size(); ++j) {
    if (!person.joints[j].present()) continue;
    if (!person.covariances[j].has_value()) return false;
    sum_m2 += person.covariances[j]->trace() / 3.0;
    ++count;
  }
  return count > 0 && sum_m2 < count * kSureSigma * kSureSigma;
}

// Whether one of `people` is at the position of `pose`: joints within 0.3 m on
// average, closer than two people stay for long.
bool IsTaken(const Pose3d& pose, const std::vector<PersonPose>& people) {
  constexpr double kSamePlace = 0.3;  // m
  return std::any_of(
      people.begin(), people.end(), [&](const PersonPose& person) {
        const auto distance_m = MeanDistance(pose, person.joints);
        return distance_m.has_value() && *distance_m < kSamePlace;
      });
}

}  // namespace

SecondPass::SecondPass(SceneModel scene, const Skeleton& detection_skeleton,
                       const TrackerOptions& options,
                       EstimatorFactory estimator)
    : scene_(std::move(scene)),
      options_(WithScaledGates(options.At(scene_.frame_rate_hz), scene_.cameras,
                               scene_.frame_rate_hz)),
      make_estimator_(std::move(estimator)),
      epipolar_(scene_.cameras),
      observations_(scene_.cameras, detection_skeleton, scene_.skeleton,
                    options_.life.min_found_joints,
                    options_.suppresses_duplicates()),
      matcher_(options_.association, scene_.skeleton.association_joints()),
      evidence_(scene_, epipolar_, options_),
      max_lost_(
          FromSeconds(options_.life.max_age_frames / scene_.frame_rate_hz)),
      matches_(scene_.cameras.size()),
      earlier_(observations_) {
  if (AllViewMatcher::AppliesTo(scene_.skeleton)) {
    all_views_.emplace(scene_.cameras, scene_.skeleton.association_joints(),
                       options_.gates.detector_px);
  }
}

void SecondPass::MatchViews(const std::vector<AssociationTarget>& targets,
                            double age_s,
                            const std::vector<Span<Observation>>& views,
                            std::vector<std::vector<int>>* matches) {
  if (all_views_.has_value()) {
    std::vector<ExpectedPerson> people;
    for (const AssociationTarget& target : targets) {
      people.push_back({target.pose, ExpectedSigma(age_s)});
    }
    const std::vector<std::vector<char>> barred(views.size());
    all_views_->Match(people, views, barred, matches);
    return;
  }
  matches->resize(views.size());
  for (size_t v = 0; v < views.size(); ++v) {
    matcher_.Match(targets, views[v], scene_.cameras[v], /*barred=*/{},
                   &(*matches)[v]);
  }
}

void SecondPass::ExtendEnds(const std::vector<TrackFrame>& first_pass,
                            const std::set<TrackId>& but) {
  runs_ = FindRuns(first_pass);
  for (const TrackId id : but) runs_.erase(id);
}

void SecondPass::Process(const DetectionFrame& frame, TrackFrame first_pass) {
  TrackFrame& written = frames_.emplace_back();
  written.frame = frame.frame;
  written.time = frame.time;
  // Replaced by WritePerson where the second pass has an estimate.
  written.people = std::move(first_pass.people);
  const std::vector<PersonPose>& people = written.people;
  observations_.Prepare(frame);
  targets_.clear();
  for (const PersonPose& person : people) {
    targets_.push_back({&person.joints, 1.0});
  }
  std::vector<Span<Observation>> views;
  for (size_t v = 0; v < matches_.size(); ++v) {
    views.push_back(observations_.OfView(v));
  }
  MatchViews(targets_, 0.0, views, &matches_);
  Recent now;
  now.index = frames_.size() - 1;
  for (size_t v = 0; v < matches_.size(); ++v) {
    now.taken.emplace_back(observations_.OfView(v).size(), 0);
  }
  for (size_t t = 0; t < targets_.size(); ++t) {
    const PersonPose& person = people[t];
    const TrackRun* run = FindRun(person.id, &TrackRun::first, frame.frame);
    if (run != nullptr) ExtendBack(person, frame.time, *run);
    used_views_.clear();
    for (size_t v = 0; v < matches_.size(); ++v) {
      const int match = matches_[v][t];
      if (match < 0) continue;
      used_views_.push_back({&observations_.OfView(v)[match], 0.0});
      now.taken[v][match] = 1;
    }
    AddFrame(frame.frame, frame.time, person.id, person.joints);
  }
  if (runs_.empty()) {
    PackBefore(frames_.size());
    return;
  }
  now.detections = frame;
  ExtendOn(&now);
  for (const PersonPose& person : people) {
    const TrackRun* run = FindRun(person.id, &TrackRun::last, frame.frame);
    if (run == nullptr) continue;
    followers_.try_emplace(person.id,
                           Following{EndFollower(person.joints, frame.time,
                                                 run->last_velocity_mps),
                                     ends_++});
  }
  Remember(std::move(now));
}

void SecondPass::AddFrame(int64_t frame, TimeNs time, TrackId id,
                          const Pose3d& start) {
  evidence_.Begin(frame, time, &work_);
  if (!used_views_.empty()) evidence_.Update(used_views_, start, &work_);
  // Joints that were not triangulated start at the smoothed pose.
  work_.has_initial = true;
  work_.initial = start;
  for (size_t j = 0; j < start.size(); ++j) {
    if (work_.triangulated[j])
      work_.initial[j] = evidence_.reconstruction().pose[j];
  }
  std::unique_ptr<Estimator>& estimator = estimators_[id];
  if (estimator == nullptr) estimator = make_estimator_(scene_);
  estimator->Add(work_);
}

const TrackRun* SecondPass::FindRun(TrackId id, int64_t TrackRun::*end,
                                    int64_t frame) const {
  const auto runs = runs_.find(id);
  if (runs == runs_.end()) return nullptr;
  for (const TrackRun& run : runs->second) {
    if (run.*end == frame) return &run;
  }
  return nullptr;
}

SecondPass::Seen SecondPass::MatchUnmatched(
    const Pose3d& expected, double age_s, const Recent& recent,
    const FrameObservations& observations) {
  used_views_.clear();
  used_places_.clear();
  free_.clear();
  std::vector<Place> places;  // of free_
  std::vector<size_t> first(scene_.cameras.size() + 1, 0);
  for (size_t v = 0; v < scene_.cameras.size(); ++v) {
    for (size_t o = 0; o < observations.OfView(v).size(); ++o) {
      if (recent.taken[v][o]) continue;
      free_.push_back(observations.OfView(v)[o]);
      places.push_back({v, o});
    }
    first[v + 1] = free_.size();
  }
  std::vector<Span<Observation>> views;
  for (size_t v = 0; v < scene_.cameras.size(); ++v) {
    views.emplace_back(free_.data() + first[v], first[v + 1] - first[v]);
  }
  std::vector<std::vector<int>> matches;
  MatchViews({{&expected, 1.0}}, age_s, views, &matches);
  for (size_t v = 0; v < scene_.cameras.size(); ++v) {
    const int match = matches[v][0];
    if (match < 0) continue;
    const size_t found = first[v] + static_cast<size_t>(match);
    used_views_.push_back({&free_[found], 0.0});
    used_places_.push_back(places[found]);
  }
  if (all_views_.has_value() && used_views_.size() < 2) {
    // A single view does not identify a person of few joints.
    used_views_.clear();
    used_places_.clear();
  }
  if (used_views_.empty()) return Seen::kInNoView;
  if (used_views_.size() < 2 || !evidence_.TryUpdate(used_views_, expected)) {
    return Seen::kInOneView;
  }
  return Seen::kInTwoViews;
}

void SecondPass::Take(Recent* recent) const {
  for (const Place& place : used_places_) {
    recent->taken[place.view][place.index] = 1;
  }
}

void SecondPass::ExtendBack(const PersonPose& person, TimeNs time,
                            const TrackRun& run) {
  followers_.erase(person.id);
  const std::vector<Beyond>& before = beyond_[person.id];
  const int64_t stop = before.empty() ? -1 : before.back().frame;
  EndFollower follower(person.joints, time, run.first_velocity_mps);
  std::vector<Pose3d> expected;  // one per frame, the last frame first
  std::vector<double> ages_s;    // time since the views last agreed
  std::vector<Seen> seen;
  for (size_t r = recent_.size(); r-- > 0;) {
    Recent& recent = recent_[r];
    const TrackFrame& written = frames_[recent.index];
    // The person is already in this frame in another run or, up to `stop`, in
    // another extension.
    const bool is_there = std::any_of(
        written.people.begin(), written.people.end(),
        [&](const PersonPose& other) { return other.id == person.id; });
    if (is_there || written.frame <= stop ||
        follower.agreed() - written.time > max_lost_) {
      break;
    }
    expected.push_back(follower.At(written.time));
    ages_s.push_back(ToSeconds(follower.agreed() - written.time));
    earlier_.Prepare(recent.detections);
    seen.push_back(
        MatchUnmatched(expected.back(), ages_s.back(), recent, earlier_));
    if (seen.back() != Seen::kInTwoViews) continue;
    if (IsTaken(evidence_.reconstruction().pose, written.people)) {
      seen.pop_back();
      break;
    }
    follower.Agree(evidence_.reconstruction().pose, written.time);
  }
  while (!seen.empty() && seen.back() == Seen::kInNoView) seen.pop_back();
  const int end = ends_++;
  for (size_t k = seen.size(); k-- > 0;) {
    Recent& recent = recent_[recent_.size() - 1 - k];
    earlier_.Prepare(recent.detections);
    MatchUnmatched(expected[k], ages_s[k], recent, earlier_);
    Take(&recent);
    const TrackFrame& written = frames_[recent.index];
    AddFrame(written.frame, written.time, person.id, expected[k]);
    beyond_[person.id].push_back({written.frame, seen[k], end, true});
  }
}

void SecondPass::ExtendOn(Recent* now) {
  const TrackFrame& written = frames_[now->index];
  for (auto at = followers_.begin(); at != followers_.end();) {
    EndFollower& follower = at->second.follower;
    const Pose3d expected = follower.At(written.time);
    const Seen seen =
        MatchUnmatched(expected, ToSeconds(written.time - follower.agreed()),
                       *now, observations_);
    const bool agreed = seen == Seen::kInTwoViews;
    if (written.time - follower.agreed() > max_lost_ ||
        (agreed && IsTaken(evidence_.reconstruction().pose, written.people))) {
      at = followers_.erase(at);
      continue;
    }
    if (agreed) follower.Agree(evidence_.reconstruction().pose, written.time);
    Take(now);
    AddFrame(written.frame, written.time, at->first, expected);
    beyond_[at->first].push_back({written.frame, seen, at->second.end, false});
    ++at;
  }
}

void SecondPass::Remember(Recent now) {
  const TimeNs time = now.detections.time;
  recent_.push_back(std::move(now));
  while (time - recent_.front().detections.time > kLongestBack) {
    recent_.pop_front();
  }
  PackBefore(recent_.front().index);
}

void SecondPass::PackBefore(size_t end) {
  for (; packed_end_ < end; ++packed_end_) {
    for (PersonPose& person : frames_[packed_end_].people) {
      packed_[person.id].Push(person);
      PersonPose nobody;
      nobody.id = person.id;
      person = std::move(nobody);
    }
  }
}

std::map<int64_t, bool> SecondPass::KeptBeyond(
    const std::vector<Beyond>& beyond,
    const std::vector<FinalPose>& finals) const {
  std::map<int64_t, const PersonPose*> pose_at;
  for (const FinalPose& one : finals) pose_at[one.frame] = &one.person;
  std::map<int64_t, bool> kept;
  for (size_t begin = 0, stop = 0; begin < beyond.size(); begin = stop) {
    while (stop < beyond.size() && beyond[stop].end == beyond[begin].end) {
      ++stop;
    }
    // Ordered from the end of the track outwards.
    std::vector<Beyond> end(beyond.begin() + static_cast<long>(begin),
                            beyond.begin() + static_cast<long>(stop));
    if (end.front().backward) std::reverse(end.begin(), end.end());
    size_t sure = 0;
    for (size_t k = 0; k < end.size(); ++k) {
      if (end[k].seen == Seen::kInTwoViews) sure = k + 1;
    }
    while (sure < end.size() && end[sure].seen == Seen::kInOneView) {
      const PersonPose* pose = pose_at[end[sure].frame];
      if (pose == nullptr || !IsSure(*pose)) break;
      ++sure;
    }
    for (size_t k = 0; k < end.size(); ++k) kept[end[k].frame] = k < sure;
  }
  return kept;
}

void SecondPass::WritePerson(TrackId id, std::vector<FinalPose> finals) {
  const std::map<int64_t, bool> kept = KeptBeyond(beyond_[id], finals);
  PackedPoses& first_pass = packed_[id];
  auto at = frames_.begin();
  for (FinalPose& final_pose : finals) {
    at = std::lower_bound(
        at, frames_.end(), final_pose.frame,
        [](const TrackFrame& f, int64_t n) { return f.frame < n; });
    CHECK(at != frames_.end() && at->frame == final_pose.frame);
    const bool is_empty = CountPresent(final_pose.person.joints) == 0;
    final_pose.person.id = id;
    const auto added = kept.find(final_pose.frame);
    if (added != kept.end()) {
      if (is_empty || !added->second) continue;
      const auto place = std::lower_bound(
          at->people.begin(), at->people.end(), id,
          [](const PersonPose& one, TrackId other) { return one.id < other; });
      at->people.insert(place, std::move(final_pose.person));
      continue;
    }
    const auto person =
        std::find_if(at->people.begin(), at->people.end(),
                     [&](const PersonPose& one) { return one.id == id; });
    CHECK(person != at->people.end() && !first_pass.empty());
    *person = first_pass.Pop();
    person->id = id;
    if (is_empty) continue;
    AddMissing(*person, &final_pose.person);
    *person = std::move(final_pose.person);
  }
}

std::vector<TrackFrame> SecondPass::Finish(int threads) {
  PackBefore(frames_.size());
  std::vector<TrackId> ids;
  for (const auto& one : estimators_) ids.push_back(one.first);
  // Each solution is copied and freed at once, to bound memory.
  std::mutex writing;
  ParallelFor(threads, static_cast<int>(ids.size()), [&](int i) {
    std::unique_ptr<Estimator>& estimator = estimators_.at(ids[i]);
    std::vector<FinalPose> finals;
    estimator->Finish();
    estimator->ExtractFinals(&finals);
    estimator.reset();
    const std::lock_guard<std::mutex> lock(writing);
    WritePerson(ids[i], std::move(finals));
  });
  estimators_.clear();
  return std::move(frames_);
}

}  // namespace kinegraph
