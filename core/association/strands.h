// Which detection of a view goes on from which of the frames before, by the
// image alone, and whose they were.
#ifndef KINEGRAPH_CORE_ASSOCIATION_STRANDS_H_
#define KINEGRAPH_CORE_ASSOCIATION_STRANDS_H_

#include <optional>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/span.h"
#include "core/base/time.h"
#include "core/data/observation.h"

namespace kinegraph {

// The strands of one view: detections that clearly show one person from frame
// to frame. A detection goes on with the strand that is near, where no other
// strand and no other detection comes near enough to be meant as well. Where
// that is not clear the strands end and new ones begin, so that a strand is
// short rather than wrong.
//
// A strand is held by the track that was given its detections for long enough:
// what goes on from there is that person still.
class ViewStrands {
 public:
  // `joints` are those that count (Skeleton::association_joints).
  explicit ViewStrands(std::vector<int> joints) : joints_(std::move(joints)) {}

  // The detections of the next frame.
  void Follow(Span<Observation> observations, TimeNs time);

  // Of the detections of that frame, by their index: the track that holds the
  // strand.
  std::optional<TrackId> HolderOf(size_t observation_idx) const;
  // Since when that one has had it without a break.
  TimeNs HeldSince(size_t observation_idx) const {
    return strands_[strand_of_[observation_idx]].since;
  }
  // The detection was given to a track, and that fitted.
  void Claim(size_t observation_idx, TrackId track);

 private:
  struct Strand {
    TimeNs time = 0;  // of the newest detection
    std::vector<Keypoint> joints;
    // Who had it last, since when, and until when.
    TrackId owner;
    TimeNs since = 0;
    TimeNs until = 0;
  };

  double Distance(const std::vector<Keypoint>& a,
                  const std::vector<Keypoint>& b) const;
  // How far a detection may be from the strand that it goes on with [px].
  double Gate(const Observation& observation, const Strand& strand) const;
  // The strand that clearly goes on with a detection; -1: none.
  int Clearly(size_t observation_idx,
              const std::vector<double>& distances) const;

  std::vector<int> joints_;
  TimeNs now_ = 0;
  std::vector<Strand> strands_;
  std::vector<size_t> strand_of_;  // [observation]
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_STRANDS_H_
