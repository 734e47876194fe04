// Runs commands in tests: those that must succeed and those that must fail.
#ifndef KINEGRAPH_TESTS_APPS_COMMAND_H_
#define KINEGRAPH_TESTS_APPS_COMMAND_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {

// The output of a command that succeeds.
inline ProgramOutcome Done(const std::string& command,
                           const std::string& arguments) {
  ProgramOutcome outcome = RunProgram(command, arguments);
  EXPECT_EQ(outcome.exit_code, 0) << command << " " << arguments << "\n"
                                  << outcome.errors;
  return outcome;
}

// The message of a command that rejects its input: one line, exit code 2.
inline std::string Refusal(const std::string& command,
                           const std::string& arguments) {
  const ProgramOutcome outcome = RunProgram(command, arguments);
  EXPECT_EQ(outcome.exit_code, 2) << command << " " << arguments;
  EXPECT_EQ(outcome.output, "") << command << " " << arguments;
  EXPECT_THAT(outcome.errors, ::testing::MatchesRegex("kinegraph-" + command +
                                                      ": error: [^\n]+\n"))
      << command << " " << arguments;
  return outcome.errors;
}

// A test with a folder for the files of its commands.
class CommandTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const {
    return (folder_.path() / name).string();
  }

  const TemporaryFolder folder_;
};

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_APPS_COMMAND_H_
