#include "tests/support/program.h"

#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/support/test_data.h"

namespace kinegraph::testing {

ProgramOutcome RunProgram(const std::string& command,
                          const std::string& arguments) {
  const TemporaryFolder folder;
  const std::filesystem::path output = folder.path() / "stdout";
  const std::filesystem::path errors = folder.path() / "stderr";
  const std::string line =
      "'" + BuildFile("apps/kinegraph-" + command).string() + "' " + arguments +
      " > '" + output.string() + "' 2> '" + errors.string() + "'";
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ContentOf(output),
          ContentOf(errors)};
}

std::string ContentOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  return content.str();
}

}  // namespace kinegraph::testing
