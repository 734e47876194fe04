// Where the running program is.
#ifndef KINEGRAPH_APPS_COMMON_PROGRAM_PATH_H_
#define KINEGRAPH_APPS_COMMON_PROGRAM_PATH_H_

#include <string>

namespace kinegraph {

// Its file; empty when the system does not tell.
std::string ProgramPath();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_PROGRAM_PATH_H_
