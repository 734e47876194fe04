// Covariances of a person's joints that are coupled (PersonProblem::coupled).
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_PERSON_SYSTEM_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_PERSON_SYSTEM_H_

#include <cstddef>
#include <vector>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Covariances of every joint's state in every frame by exact block-tridiagonal
// selected inversion, frames as blocks. To bound memory, the results of the
// backward sweep are kept for one segment of frames at a time, of about
// `segment_bytes` but at least eight frames, and recomputed for the next.
// `correction` as from InformationCorrection. Fills covariances[joint][frame]
// for frames before `frame_end`. False if the information is not positive
// definite.
bool PersonCovariances(const PersonProblem& problem, double correction,
                       size_t frame_end,
                       std::vector<std::vector<Matrix6d>>* covariances,
                       size_t segment_bytes = 16 << 20);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_PERSON_SYSTEM_H_
