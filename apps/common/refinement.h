// What a refinement of cameras and clocks changed, for people and files.
#ifndef KINEGRAPH_APPS_COMMON_REFINEMENT_H_
#define KINEGRAPH_APPS_COMMON_REFINEMENT_H_

#include <string>

#include "solvers/session/ready_recording.h"

namespace kinegraph {

// What a later run repeats; the steps with what was decided and why; each
// camera's change with its standard deviation: degrees, millimetres, pixels,
// per cent, milliseconds, parts per million; the turn of the whole world that
// followed.
std::string RefinementJson(const ReadyRecording& recording);

// One line a step: "rotation: taken, 7.31 px instead of 9.02 on the other half
// of the recording"; one for the floor.
std::string RefinementText(const ReadyRecording& recording);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_REFINEMENT_H_
