// Identity scores: CLEAR MOT (Bernardin and Stiefelhagen 2008), IDF1 (Ristani
// et al. 2016) and HOTA (Luiten et al. 2020), on poses in space.
#ifndef KINEGRAPH_CORE_EVALUATION_IDENTITY_H_
#define KINEGRAPH_CORE_EVALUATION_IDENTITY_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {

// People that a ground truth annotates.
enum class Annotated {
  kEverybody,
  kSome,  // there may be people without annotation
};

struct IdentityOptions {
  std::vector<FrameRange> frames;  // of the tracks; empty: all
  Annotated annotated = Annotated::kEverybody;
};

// HOTA's similarity of two poses is 1 - d / (2 gate), at least 0, with d their
// mean distance over joints and the gate kPersonGateM: at the threshold 0.5 the
// two may be a gate apart, as for MOTA and IDF1.
inline constexpr int kHotaThresholdCount = 19;  // 0.05, 0.10, ... 0.95

// One threshold of HOTA, or the mean over them. NaN without people.
struct HotaScores {
  double hota = 0.0;
  double detection = 0.0;     // DetA
  double association = 0.0;   // AssA
  double localisation = 0.0;  // LocA
};

struct IdentityResult {
  int64_t true_person_frames = 0;
  int64_t found_person_frames = 0;
  int64_t true_people = 0;
  int64_t identities = 0;  // found

  int64_t matches = 0;
  int64_t misses = 0;           // true person-frames without a match
  int64_t false_positives = 0;  // found person-frames without a match
  // Times a true person was matched to another identity than before.
  int64_t switches = 0;
  // Times a matched true person was lost and matched again later.
  int64_t fragments = 0;
  // Person-frames explained if every true person has one identity for the
  // whole recording, chosen to maximise their number.
  int64_t identity_true_positives = 0;
  // Found person-frames that are not scored; excluded from found_person_frames.
  int64_t on_hidden_people = 0;    // where the truth has a hidden person
  int64_t beside_annotations = 0;  // where there is no annotation (kSome)
  // True person-frames that are hidden; excluded from true_person_frames.
  int64_t hidden_person_frames = 0;
  std::array<HotaScores, kHotaThresholdCount> hota_at{};

  // 1 - (misses + false positives + switches) / true person-frames; NaN if
  // there are none.
  double Mota() const;
  double Idf1() const;      // NaN if neither result has people
  HotaScores Hota() const;  // means over the thresholds
};

// A pose and a true person can match if the mean distance of their joints of
// the same name is within the gate, kPersonGateM (for HOTA, see
// kHotaThresholdCount).
//
// In each frame a true person keeps the identity matched last if the two are
// within the gate and no other person has had that identity since; the other
// people are matched one-to-one.
//
// An incomplete truth is scored as follows.
//
// - Frames that it does not contain are not scored; a frame that it contains
//   without people is empty.
// - A true person without an observed joint is hidden: not finding them is no
//   miss, and an unmatched pose at their position is not scored.
// - With Annotated::kSome a pose that is not within the gate of any annotated
//   person is not scored. A second pose on an annotated person is a false
//   positive.
IdentityResult EvaluateIdentity(const TrackSequence& truth,
                                const TrackSequence& tracks,
                                const IdentityOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_IDENTITY_H_
