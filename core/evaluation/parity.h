// Agreement of two results of the same recording, joint by joint.
#ifndef KINEGRAPH_CORE_EVALUATION_PARITY_H_
#define KINEGRAPH_CORE_EVALUATION_PARITY_H_

#include <cstdint>
#include <vector>

#include "core/base/frame_range.h"
#include "core/base/ids.h"
#include "core/data/pose.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

struct ParityOptions {
  double near_m = 1e-3;            // visually equal
  double very_near_m = 1e-5;       // equal up to rounding
  std::vector<FrameRange> frames;  // empty: all
};

// The joint with the greatest distance between the two results.
struct WorstJoint {
  double distance_m = 0.0;
  int64_t frame = 0;
  TrackId id;     // of the reference
  int joint = 0;  // of the reference
};

struct ParityResult {
  // Joints that both results have, at most ParityOptions::near_m or very_near_m
  // apart. The total includes every joint of either result that the other's
  // skeleton has, also of people without a counterpart, so that omissions
  // always count.
  Share near;
  Share very_near;
  int64_t joints_missing = 0;  // in the reference only
  int64_t joints_extra = 0;    // in the tracks only
  WorstJoint worst;            // among joints that both have
  // Whether the pairs of all frames map identities one-to-one.
  bool identities_one_to_one = true;
  int64_t identities = 0;            // of the tracks
  int64_t reference_identities = 0;  // of the reference
  int64_t person_frames = 0;
  int64_t reference_person_frames = 0;
  int64_t paired_person_frames = 0;
};

// People are paired one-to-one in each frame by mean distance over the joints
// of the same name, without a gate. Joints that one skeleton lacks are not
// compared.
ParityResult EvaluateParity(const TrackSequence& reference,
                            const TrackSequence& tracks,
                            const ParityOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_PARITY_H_
