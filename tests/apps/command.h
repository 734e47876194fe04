// Commands as tests run them: one that shall succeed, one that shall refuse.
#ifndef KINEGRAPH_TESTS_APPS_COMMAND_H_
#define KINEGRAPH_TESTS_APPS_COMMAND_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/program.h"

namespace kinegraph::testing {

// What a command says that comes to a good end.
inline ProgramOutcome Done(const std::string& command,
                           const std::string& arguments) {
  ProgramOutcome outcome = RunProgram(command, arguments);
  EXPECT_EQ(outcome.exit_code, 0) << command << " " << arguments << "\n"
                                  << outcome.errors;
  return outcome;
}

// What a command says that does not accept its input: one line, exit code 2.
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

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_APPS_COMMAND_H_
