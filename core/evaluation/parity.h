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
  double near_m = 1e-3;            // "equal" for the eye
  double very_near_m = 1e-5;       // equal but for rounding
  std::vector<FrameRange> frames;  // none: all
};

// Where the two lie farthest apart, or one lacks the joint.
struct WorstJoint {
  double distance_m = 0.0;
  int64_t frame = 0;
  TrackId id;     // of the reference
  int joint = 0;  // of the reference
};

struct ParityResult {
  // Joints that both have within the distance. The total counts every joint
  // that either has, those of people without a counterpart too, so that
  // leaving something out is never free.
  Share near;
  Share very_near;
  int64_t joints_missing = 0;  // the reference has it, the other does not
  int64_t joints_extra = 0;    // the other has it, the reference does not
  WorstJoint worst;            // of the joints that both have
  // Whether the pairs of all frames map identities one-to-one.
  bool identities_one_to_one = true;
  int64_t identities = 0;            // of the tracks
  int64_t reference_identities = 0;  // of the reference
  int64_t person_frames = 0;
  int64_t reference_person_frames = 0;
  int64_t paired_person_frames = 0;
};

// People are paired in each frame one-to-one by mean distance over the joints
// of the same name, without a gate. Joints that one skeleton lacks are not
// compared.
ParityResult EvaluateParity(const TrackSequence& reference,
                            const TrackSequence& tracks,
                            const ParityOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_PARITY_H_
