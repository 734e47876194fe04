#include "core/tracking/track_ends.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace kinegraph {
namespace {

constexpr double kVelocitySeconds = 0.2;  // over which an end's is taken
constexpr double kFades = 0.5;            // s
constexpr double kNewShare = 0.3;         // of a velocity that was just seen
constexpr double kSamePlace = 0.3;        // m

struct Place {
  int64_t index;  // of the frame
  int64_t frame;
  TimeNs time;
  Eigen::Vector3d centre_m;
};

// Mean movement of the joints that both poses have.
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

// From the place at `end` towards the inside of places [begin, stop).
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

bool AtOnePlace(const Pose3d& a, const Pose3d& b, double within_m) {
  double sum_m = 0.0;
  int count = 0;
  for (size_t j = 0; j < a.size() && j < b.size(); ++j) {
    if (!a[j].present() || !b[j].present()) continue;
    sum_m += (a[j].position_m - b[j].position_m).norm();
    ++count;
  }
  return count > 0 && sum_m / count < within_m;
}

bool SeenAtOnePlace(const Pose3d& a, const Pose3d& b, double within_m) {
  constexpr int kABody = 3;  // joints that tell where it is and how it stands
  int seen = 0;
  int near = 0;
  for (size_t j = 0; j < a.size() && j < b.size(); ++j) {
    if (a[j].status != JointStatus::kObserved ||
        b[j].status != JointStatus::kObserved) {
      continue;
    }
    ++seen;
    near += (a[j].position_m - b[j].position_m).norm() < within_m;
  }
  return seen >= kABody && 2 * near > seen;
}

bool IsTaken(const Pose3d& pose, const std::vector<PersonPose>& people) {
  return std::any_of(people.begin(), people.end(),
                     [&](const PersonPose& person) {
                       return AtOnePlace(pose, person.joints, kSamePlace);
                     });
}

}  // namespace kinegraph
