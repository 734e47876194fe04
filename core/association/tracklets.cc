#include "core/association/tracklets.h"

#include <algorithm>
#include <limits>

#include "core/data/box.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {
namespace {

// Gate from one detection to the next, as a share of the person's size in the
// image: the detector's noise, and twice the speed of a runner (1.7 m tall, 4
// m/s across the view).
constexpr double kNoise = 0.06;
constexpr double kPerSecond = 2.5;
// Greatest ratio of the nearest to the second nearest distance.
constexpr double kMaxRatio = 0.5;
constexpr double kMinCommon = 6.0;  // joints of 17
// A tracklet ends after so long without a detection.
constexpr double kMissed = 0.2;  // s
// It belongs to the track that has had it for so long, ...
constexpr double kOwned = 0.2;  // s
// ... until the track has not had it for so long.
constexpr double kForgotten = 2.0;  // s

constexpr double kFar = std::numeric_limits<double>::max();

}  // namespace

// Mean over the joints that both have [px].
double ViewTracklets::Distance(const std::vector<Keypoint>& a,
                               const std::vector<Keypoint>& b) const {
  double sum_px = 0.0;
  int common = 0;
  for (const int j : joints_) {
    if (!a[j].found || !b[j].found) continue;
    sum_px += (a[j].px - b[j].px).norm();
    ++common;
  }
  if (common == 0 || common < ScaledJoints(kMinCommon, joints_.size())) {
    return kFar;
  }
  return sum_px / common;
}

double ViewTracklets::Gate(const Observation& observation,
                           const Tracklet& tracklet) const {
  const double size_px = std::max(DiagonalPx(BoxAround(observation.joints)),
                                  DiagonalPx(BoxAround(tracklet.joints)));
  return size_px * (kNoise + kPerSecond * ToSeconds(now_ - tracklet.time));
}

int ViewTracklets::Unambiguous(size_t observation_idx,
                               const std::vector<double>& distances) const {
  const size_t tracklets = tracklets_.size();
  const double* of = distances.data() + observation_idx * tracklets;
  const auto best =
      static_cast<size_t>(std::min_element(of, of + tracklets) - of);
  if (best == tracklets || of[best] == kFar) return -1;
  for (size_t s = 0; s < tracklets; ++s) {
    if (s != best && of[best] > kMaxRatio * of[s]) return -1;
  }
  for (size_t k = 0; k * tracklets < distances.size(); ++k) {
    if (k == observation_idx) continue;
    if (of[best] > kMaxRatio * distances[k * tracklets + best]) return -1;
  }
  return static_cast<int>(best);
}

void ViewTracklets::Follow(Span<Observation> observations, TimeNs time) {
  now_ = time;
  tracklets_.erase(std::remove_if(tracklets_.begin(), tracklets_.end(),
                                  [&](const Tracklet& tracklet) {
                                    return time - tracklet.time >
                                           FromSeconds(kMissed);
                                  }),
                   tracklets_.end());
  const size_t known = tracklets_.size();
  std::vector<double> distances(observations.size() * known, kFar);
  for (size_t k = 0; k < observations.size(); ++k) {
    for (size_t s = 0; s < known; ++s) {
      distances[k * known + s] =
          Distance(observations[k].joints, tracklets_[s].joints);
    }
  }
  std::vector<Tracklet> going_on;
  std::vector<char> ended(known, 0);
  tracklet_of_.clear();
  for (size_t k = 0; k < observations.size(); ++k) {
    tracklet_of_.push_back(going_on.size());
    Tracklet tracklet;
    const int from = Unambiguous(k, distances);
    if (from >= 0 &&
        distances[k * known + static_cast<size_t>(from)] <=
            Gate(observations[k], tracklets_[static_cast<size_t>(from)])) {
      tracklet = tracklets_[static_cast<size_t>(from)];
      ended[static_cast<size_t>(from)] = 1;
    } else {
      for (size_t s = 0; s < known; ++s) {
        if (distances[k * known + s] <= Gate(observations[k], tracklets_[s])) {
          ended[s] = 1;
        }
      }
    }
    tracklet.time = time;
    tracklet.joints = observations[k].joints;
    going_on.push_back(std::move(tracklet));
  }
  for (size_t s = 0; s < known; ++s) {
    if (!ended[s]) going_on.push_back(std::move(tracklets_[s]));
  }
  tracklets_ = std::move(going_on);
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
