// What a refinement of cameras and clocks changed, for people and files.
#ifndef KINEGRAPH_APPS_COMMON_REFINEMENT_H_
#define KINEGRAPH_APPS_COMMON_REFINEMENT_H_

#include <string>

#include "solvers/session/ready_take.h"

namespace kinegraph {

// What a later run repeats; the steps with what was decided and why; each
// camera's change with its standard deviation: degrees, millimetres, pixels,
// per cent, milliseconds, parts per million; the turn of the whole world that
// followed.
std::string RefinementJson(const ReadyTake& take);

// One line a step: "rotation: taken, 7.31 px instead of 9.02 on the other half
// of the take"; one for the floor.
std::string RefinementText(const ReadyTake& take);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_REFINEMENT_H_
