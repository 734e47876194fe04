// Do people keep their identity: CLEAR MOT (Bernardin and Stiefelhagen 2008)
// and IDF1 (Ristani et al. 2016), on poses in space.
#ifndef KINEGRAPH_CORE_EVALUATION_IDENTITY_H_
#define KINEGRAPH_CORE_EVALUATION_IDENTITY_H_

#include <cstdint>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {

struct IdentityOptions {
  std::vector<FrameRange> frames;  // none: all of either
  double gate_m = kPersonGateM;    // mean distance over joints of the same name
};

struct IdentityResult {
  int64_t true_person_frames = 0;
  int64_t found_person_frames = 0;
  int64_t true_people = 0;
  int64_t identities = 0;  // found

  int64_t matches = 0;
  int64_t misses = 0;           // true person-frames without a match
  int64_t false_positives = 0;  // found person-frames without a match
  // A true person is matched to another identity than the last time.
  int64_t switches = 0;
  // A true person that was matched is lost and later matched again.
  int64_t fragments = 0;
  // Frames explained when every true person stands for one identity, chosen
  // once for the whole take so that they are most.
  int64_t identity_true_positives = 0;

  // 1 - (misses + false positives + switches) / true person-frames; NaN when
  // there are none.
  double Mota() const;
  double Idf1() const;  // NaN when there is nobody on either side
};

// In each frame a true person keeps the identity it had while the two stay
// within the gate; the others are matched one-to-one. Frames that only one side
// has count. Where a ground truth does not annotate everybody (Shelf), people
// found beside it count as false positives and MOTA says little.
IdentityResult EvaluateIdentity(const TrackSequence& truth,
                                const TrackSequence& tracks,
                                const IdentityOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_IDENTITY_H_
