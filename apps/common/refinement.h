// What a refinement of cameras and clocks changed, for people and files.
#ifndef KINEGRAPH_APPS_COMMON_REFINEMENT_H_
#define KINEGRAPH_APPS_COMMON_REFINEMENT_H_

#include <string>

#include "solvers/session/refine_take.h"

namespace kinegraph {

// The steps with what was decided and why, and each camera's change with its
// standard deviation: degrees, millimetres, pixels, per cent, milliseconds,
// parts per million.
std::string RefinementJson(const RefinedTake& take);

// One line a step: "rotation: taken, 7.31 px instead of 9.02 on the other half
// of the take".
std::string RefinementText(const RefinedTake& take);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_REFINEMENT_H_
