// Describes the computer and the build with which results were produced.
#ifndef KINEGRAPH_APPS_COMMON_MACHINE_H_
#define KINEGRAPH_APPS_COMMON_MACHINE_H_

#include <string>

namespace kinegraph {

struct Machine {
  std::string processor;  // "unknown" if not available
  int threads = 0;        // number of logical processors
  std::string system;     // "Debian GNU/Linux 12 (bookworm)"
  std::string compiler;
  // Short commit hash of the repository that contains configs/, read at run
  // time (not at build time), with "-dirty" if it has local changes; "unknown"
  // outside a repository.
  std::string commit;
};

Machine ThisMachine();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_MACHINE_H_
