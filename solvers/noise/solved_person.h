// A person as one pass over a recording solved it, kept for the next pass.
#ifndef KINEGRAPH_SOLVERS_NOISE_SOLVED_PERSON_H_
#define KINEGRAPH_SOLVERS_NOISE_SOLVED_PERSON_H_

#include <cstdint>
#include <vector>

#include "solvers/graph/outcome.h"
#include "solvers/noise/person_noise.h"

namespace kinegraph {

struct SolvedPerson {
  struct Joint {
    JointOutcome outcome;        // of all frames
    std::vector<int32_t> first;  // as JointChain::first
  };
  std::vector<FrameRecord> records;  // by frame
  std::vector<Joint> joints;
  AppliedNoise noise;
  std::vector<BoneConstraint> bones;         // of the estimate
  std::vector<BoneConstraint> stated_bones;  // of its covariances
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_SOLVED_PERSON_H_
