#include "apps/common/program_path.h"

#include <unistd.h>

#include <climits>
#include <cstddef>

namespace kinegraph {

std::string ProgramPath() {
  char buffer[PATH_MAX];
  const ssize_t length = readlink("/proc/self/exe", buffer, sizeof(buffer));
  return length > 0 ? std::string(buffer, static_cast<size_t>(length)) : "";
}

}  // namespace kinegraph
