// Runs the commands as users do.
#ifndef KINEGRAPH_TESTS_SUPPORT_PROGRAM_H_
#define KINEGRAPH_TESTS_SUPPORT_PROGRAM_H_

#include <filesystem>
#include <string>

namespace kinegraph::testing {

struct ProgramOutcome {
  int exit_code = -1;  // -1: did not exit normally
  std::string output;  // on stdout
  std::string errors;  // on stderr
};

// Runs kinegraph-`command` of this build with arguments in shell syntax.
ProgramOutcome RunProgram(const std::string& command,
                          const std::string& arguments);

// All bytes of a file; empty if it does not exist.
std::string ContentOf(const std::filesystem::path& path);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_PROGRAM_H_
