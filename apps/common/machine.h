// What a measurement was made on and with.
#ifndef KINEGRAPH_APPS_COMMON_MACHINE_H_
#define KINEGRAPH_APPS_COMMON_MACHINE_H_

#include <string>

namespace kinegraph {

struct Machine {
  std::string processor;  // "unknown" where the system does not tell
  int threads = 0;        // processors that the system offers
  std::string system;     // "Debian GNU/Linux 12 (bookworm)"
  std::string compiler;
  // Of the sources that the program was built from, short; "-dirty" after it
  // when they had changes; "unknown" without a repository.
  std::string commit;
};

Machine ThisMachine();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_MACHINE_H_
