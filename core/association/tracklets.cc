#include "core/association/tracklets.h"

#include <algorithm>
#include <limits>

#include "core/data/box.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {
namespace {

// Gate from one detection to the next, as a share of the diagonal of the
// person's box: detector noise, and per second the distance covered by a runner
// (2.5 times 1.7 m: 4 m/s across the view).
constexpr double kNoise = 0.06;
constexpr double kPerSecond = 2.5;
// Greatest ratio of the nearest distance to the second nearest.
constexpr double kMaxRatio = 0.5;
constexpr double kMinCommon = 6.0;  // joints of 17
// A tracklet ends after this time without a detection, or after the detector's
// longest pause (Follow) if that is longer.
constexpr double kMissed = 0.2;  // s
// The track last matched with a tracklet owns it after this time of matches.
constexpr double kOwned = 0.2;  // s
// The ownership lapses after this time without a match.
constexpr double kForgotten = 2.0;  // s

constexpr double kFar = std::numeric_limits<double>::max();

}  // namespace

// Mean distance [px] of the joints that both have; kFar if these are too few.
double ViewTracklets::Distance(const Tracklet& a, const Tracklet& b) const {
  double sum_px = 0.0;
  int common = 0;
  for (const int j : joints_) {
    if (!a.joints[j].found || !b.joints[j].found) continue;
    sum_px += (a.joints[j].px - b.joints[j].px).norm();
    ++common;
  }
  if (common == 0 || common < ScaledJoints(kMinCommon, joints_.size())) {
    return kFar;
  }
  return sum_px / common;
}

std::vector<ViewTracklets::Candidate> ViewTracklets::Candidates() const {
  std::vector<Candidate> candidates;
  std::vector<double> size_px;
  std::vector<double> share;
  for (const Tracklet& tracklet : tracklets_) {
    size_px.push_back(DiagonalPx(tracklet.box));
    share.push_back(kNoise + kPerSecond * ToSeconds(now_ - tracklet.time));
  }
  for (size_t k = 0; k < seen_.size(); ++k) {
    const double own_px = DiagonalPx(seen_[k].box);
    for (size_t s = 0; s < tracklets_.size(); ++s) {
      const double gate_px = std::max(own_px, size_px[s]) * share[s];
      if (GapPx(seen_[k].box, tracklets_[s].box) > gate_px) continue;
      const double distance_px = Distance(seen_[k], tracklets_[s]);
      if (distance_px <= gate_px) candidates.push_back({k, s, distance_px});
    }
  }
  return candidates;
}

bool ViewTracklets::IsAmbiguous(const Candidate& candidate) const {
  const auto is_near = [&](const Tracklet& a, const Tracklet& b) {
    return !(kMaxRatio * GapPx(a.box, b.box) > candidate.distance_px) &&
           candidate.distance_px > kMaxRatio * Distance(a, b);
  };
  for (size_t s = 0; s < tracklets_.size(); ++s) {
    if (s != candidate.tracklet &&
        is_near(seen_[candidate.observation], tracklets_[s])) {
      return true;
    }
  }
  for (size_t k = 0; k < seen_.size(); ++k) {
    if (k != candidate.observation &&
        is_near(seen_[k], tracklets_[candidate.tracklet])) {
      return true;
    }
  }
  return false;
}

void ViewTracklets::Follow(Span<Observation> observations, TimeNs time,
                           double longest_pause_s) {
  now_ = time;
  const TimeNs missed = FromSeconds(std::max(kMissed, longest_pause_s));
  tracklets_.erase(std::remove_if(tracklets_.begin(), tracklets_.end(),
                                  [&](const Tracklet& tracklet) {
                                    return time - tracklet.time > missed;
                                  }),
                   tracklets_.end());
  seen_.clear();
  tracklet_of_.clear();
  for (const Observation& observation : observations) {
    tracklet_of_.push_back(seen_.size());
    Tracklet& tracklet = seen_.emplace_back();
    tracklet.time = time;
    tracklet.joints = observation.joints;
    tracklet.box = BoxAround(observation.joints);
  }
  // A tracklet ends where its continuation is ambiguous.
  std::vector<char> ended(tracklets_.size(), 0);
  const std::vector<Candidate> candidates = Candidates();
  std::vector<const Candidate*> best(seen_.size(), nullptr);
  for (const Candidate& candidate : candidates) {
    const Candidate*& own = best[candidate.observation];
    if (own == nullptr || candidate.distance_px < own->distance_px) {
      own = &candidate;
    }
  }
  for (const Candidate*& own : best) {
    if (own != nullptr && IsAmbiguous(*own)) own = nullptr;
  }
  for (const Candidate& candidate : candidates) {
    const Candidate* own = best[candidate.observation];
    if (own == nullptr || own == &candidate) ended[candidate.tracklet] = 1;
  }
  for (size_t k = 0; k < seen_.size(); ++k) {
    if (best[k] == nullptr) continue;
    const Tracklet& from = tracklets_[best[k]->tracklet];
    seen_[k].owner = from.owner;
    seen_[k].since = from.since;
    seen_[k].until = from.until;
  }
  for (size_t s = 0; s < tracklets_.size(); ++s) {
    if (!ended[s]) seen_.push_back(std::move(tracklets_[s]));
  }
  std::swap(tracklets_, seen_);
}

std::optional<TrackId> ViewTracklets::OwnerOf(size_t observation_idx) const {
  const Tracklet& tracklet = tracklets_[tracklet_of_[observation_idx]];
  if (tracklet.owner == TrackId() ||
      tracklet.until - tracklet.since < FromSeconds(kOwned) ||
      now_ - tracklet.until > FromSeconds(kForgotten)) {
    return std::nullopt;
  }
  return tracklet.owner;
}

void ViewTracklets::Claim(size_t observation_idx, TrackId track) {
  Tracklet& tracklet = tracklets_[tracklet_of_[observation_idx]];
  if (tracklet.owner != track) {
    tracklet.owner = track;
    tracklet.since = now_;
  }
  tracklet.until = now_;
}

}  // namespace kinegraph
