#include "core/association/strands.h"

#include <algorithm>
#include <limits>

#include "core/data/box.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {
namespace {

// How far joints may go from one detection to the next, as a share of the
// person's size in the image: a detector's noise, and twice as fast as people
// run (1.7 m tall, 4 m/s across the view).
constexpr double kNoise = 0.06;
constexpr double kPerSecond = 2.5;
// Everybody else must be twice as far.
constexpr double kClearly = 0.5;
constexpr double kMinCommon = 6.0;  // joints of 17
// A detector may miss somebody for so long.
constexpr double kMissed = 0.2;  // s
// A track that had a strand for so long holds it.
constexpr double kHeld = 0.2;  // s
// Whom a track had and no longer has may be anybody's after this.
constexpr double kForgotten = 2.0;  // s

constexpr double kFar = std::numeric_limits<double>::max();

}  // namespace

// Mean over the joints that both have [px].
double ViewStrands::Distance(const std::vector<Keypoint>& a,
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

double ViewStrands::Gate(const Observation& observation,
                         const Strand& strand) const {
  const double size_px = std::max(DiagonalPx(BoxAround(observation.joints)),
                                  DiagonalPx(BoxAround(strand.joints)));
  return size_px * (kNoise + kPerSecond * ToSeconds(now_ - strand.time));
}

int ViewStrands::Clearly(size_t observation_idx,
                         const std::vector<double>& distances) const {
  const size_t strands = strands_.size();
  const double* of = distances.data() + observation_idx * strands;
  const auto best =
      static_cast<size_t>(std::min_element(of, of + strands) - of);
  if (best == strands || of[best] == kFar) return -1;
  for (size_t s = 0; s < strands; ++s) {
    if (s != best && of[best] > kClearly * of[s]) return -1;
  }
  for (size_t k = 0; k * strands < distances.size(); ++k) {
    if (k == observation_idx) continue;
    if (of[best] > kClearly * distances[k * strands + best]) return -1;
  }
  return static_cast<int>(best);
}

void ViewStrands::Follow(Span<Observation> observations, TimeNs time) {
  now_ = time;
  strands_.erase(std::remove_if(strands_.begin(), strands_.end(),
                                [&](const Strand& strand) {
                                  return time - strand.time >
                                         FromSeconds(kMissed);
                                }),
                 strands_.end());
  const size_t known = strands_.size();
  std::vector<double> distances(observations.size() * known, kFar);
  for (size_t k = 0; k < observations.size(); ++k) {
    for (size_t s = 0; s < known; ++s) {
      distances[k * known + s] =
          Distance(observations[k].joints, strands_[s].joints);
    }
  }
  std::vector<Strand> going_on;
  std::vector<char> ended(known, 0);
  strand_of_.clear();
  for (size_t k = 0; k < observations.size(); ++k) {
    strand_of_.push_back(going_on.size());
    Strand strand;
    const int from = Clearly(k, distances);
    if (from >= 0 &&
        distances[k * known + static_cast<size_t>(from)] <=
            Gate(observations[k], strands_[static_cast<size_t>(from)])) {
      strand = strands_[static_cast<size_t>(from)];
      ended[static_cast<size_t>(from)] = 1;
    } else {
      for (size_t s = 0; s < known; ++s) {
        if (distances[k * known + s] <= Gate(observations[k], strands_[s])) {
          ended[s] = 1;
        }
      }
    }
    strand.time = time;
    strand.joints = observations[k].joints;
    going_on.push_back(std::move(strand));
  }
  for (size_t s = 0; s < known; ++s) {
    if (!ended[s]) going_on.push_back(std::move(strands_[s]));
  }
  strands_ = std::move(going_on);
}

std::optional<TrackId> ViewStrands::HolderOf(size_t observation_idx) const {
  const Strand& strand = strands_[strand_of_[observation_idx]];
  if (strand.owner == TrackId() ||
      strand.until - strand.since < FromSeconds(kHeld) ||
      now_ - strand.until > FromSeconds(kForgotten)) {
    return std::nullopt;
  }
  return strand.owner;
}

void ViewStrands::Claim(size_t observation_idx, TrackId track) {
  Strand& strand = strands_[strand_of_[observation_idx]];
  if (strand.owner != track) {
    strand.owner = track;
    strand.since = now_;
  }
  strand.until = now_;
}

}  // namespace kinegraph
