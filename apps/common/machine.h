// The machine and build of a measurement.
#ifndef KINEGRAPH_APPS_COMMON_MACHINE_H_
#define KINEGRAPH_APPS_COMMON_MACHINE_H_

#include <string>

namespace kinegraph {

struct Machine {
  std::string processor;  // "unknown" if not available
  int threads = 0;        // processors offered by the system
  std::string system;     // "Debian GNU/Linux 12 (bookworm)"
  std::string compiler;
  // Short hash of the repository with the program's configurations, when called
  // (not when built), with "-dirty" if it has changes; "unknown" without one.
  std::string commit;
};

Machine ThisMachine();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_MACHINE_H_
