#include "core/tracking/proposals.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/time.h"

namespace kinegraph {
namespace {

Pose3d Inferred(Pose3d pose) {
  for (Joint3d& joint : pose) {
    if (joint.present()) joint.status = JointStatus::kInferred;
  }
  return pose;
}

// `share` of the way from `a` to `b`; joints that one lacks are the other's.
Pose3d Between(const Pose3d& a, const Pose3d& b, double share) {
  Pose3d pose = Inferred(a);
  for (size_t j = 0; j < pose.size(); ++j) {
    if (!b[j].present()) continue;
    if (!pose[j].present()) {
      pose[j] = {b[j].position_m, JointStatus::kInferred};
      continue;
    }
    pose[j].position_m += share * (b[j].position_m - a[j].position_m);
  }
  return pose;
}

// A frame in which a person is.
struct Seen {
  size_t frame_idx;
  const Pose3d* joints;
};

class Proposer {
 public:
  Proposer(const std::vector<TrackFrame>& frames, double reach_s,
           double frame_rate_hz)
      : frames_(frames),
        reach_(FromSeconds(reach_s)),
        clock_(frame_rate_hz),
        proposals_(frames.size()) {}

  void Add(TrackId id, const std::vector<Seen>& seen) {
    Beyond(id, seen.front(), -1);
    for (size_t i = 1; i < seen.size(); ++i) Gap(id, seen[i - 1], seen[i]);
    Beyond(id, seen.back(), 1);
  }

  std::vector<std::vector<ProposedPerson>> Take() {
    return std::move(proposals_);
  }

 private:
  TimeNs Distance(size_t a, size_t b) const {
    return std::abs(frames_[a].time - frames_[b].time);
  }

  void Propose(TrackId id, size_t at, Pose3d joints, TimeNs age) {
    proposals_[at].push_back(
        {id, std::move(joints), std::max(1.0, clock_.Frames(age))});
  }

  void Beyond(TrackId id, const Seen& seen, int step) {
    for (long k = static_cast<long>(seen.frame_idx) + step;
         k >= 0 && k < static_cast<long>(frames_.size()); k += step) {
      const auto at = static_cast<size_t>(k);
      const TimeNs age = Distance(at, seen.frame_idx);
      if (age > reach_) return;
      Propose(id, at, Inferred(*seen.joints), age);
    }
  }

  void Gap(TrackId id, const Seen& from, const Seen& to) {
    const double gap =
        static_cast<double>(Distance(to.frame_idx, from.frame_idx));
    for (size_t k = from.frame_idx + 1; k < to.frame_idx; ++k) {
      const TimeNs since = Distance(k, from.frame_idx);
      const TimeNs until = Distance(k, to.frame_idx);
      if (std::min(since, until) > reach_) continue;
      Propose(
          id, k,
          Between(*from.joints, *to.joints, static_cast<double>(since) / gap),
          std::min(since, until));
    }
  }

  const std::vector<TrackFrame>& frames_;
  TimeNs reach_;
  FrameClock clock_;
  std::vector<std::vector<ProposedPerson>> proposals_;
};

}  // namespace

std::vector<std::vector<ProposedPerson>> ProposePeople(
    const std::vector<TrackFrame>& frames, double reach_s,
    double frame_rate_hz) {
  std::map<TrackId, std::vector<Seen>> people;
  for (size_t f = 0; f < frames.size(); ++f) {
    for (const PersonPose& person : frames[f].people) {
      people[person.id].push_back({f, &person.joints});
    }
  }
  Proposer proposer(frames, reach_s, frame_rate_hz);
  for (const auto& [id, seen] : people) proposer.Add(id, seen);
  return proposer.Take();
}

}  // namespace kinegraph
