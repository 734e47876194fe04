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
  std::string commit;  // CommitOf the project's configs/
};

Machine ThisMachine();

// Short commit hash of the repository whose root contains the folder `configs`
// under the name configs/, read at run time (not at build time), with "-dirty"
// if tracked files have changed; "unknown" for every other folder, even one
// within a repository.
std::string CommitOf(const std::string& configs);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_MACHINE_H_
