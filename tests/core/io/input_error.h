// Checks for inputs that must be rejected with an InputError.
#ifndef KINEGRAPH_TESTS_CORE_IO_INPUT_ERROR_H_
#define KINEGRAPH_TESTS_CORE_IO_INPUT_ERROR_H_

#include <gtest/gtest.h>

#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {

// The message of the InputError that `call` throws. Fails the test if nothing
// or something else is thrown, or if the message is not one line.
template <typename Call>
std::string InputErrorOf(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_FALSE(message.empty());
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "expected an InputError, found: " << error.what();
    return {};
  }
  ADD_FAILURE() << "expected an InputError, nothing was thrown";
  return {};
}

// Expects `call` to throw an InputError whose message contains `said`.
template <typename Call>
void ExpectInputError(const Call& call, const std::string& said) {
  const std::string message = InputErrorOf(call);
  EXPECT_NE(message.find(said), std::string::npos)
      << message << "\nexpected: " << said;
}

// The message with which `read(path)` rejects a file of this name and content;
// expects it to begin with the path.
template <typename Read>
std::string FaultIn(const std::string& name, const std::string& text,
                    const Read& read) {
  const TemporaryFolder folder;
  const std::string path = folder.Write(name, text);
  std::string message = InputErrorOf([&] { read(path); });
  EXPECT_EQ(message.rfind(path, 0), 0u) << message;
  return message;
}

// Pairs of a file's text and of a text that the resulting message must contain.
using Faults = std::vector<std::pair<std::string, std::string>>;
// Expects `read` to reject a file of this name with each of the texts.
template <typename Read>
void ExpectFaultsIn(const std::string& name, const Faults& faults,
                    const Read& read) {
  EXPECT_FALSE(faults.empty());
  for (const auto& [text, said] : faults) {
    const std::string message = FaultIn(name, text, read);
    EXPECT_NE(message.find(said), std::string::npos)
        << message << "\nexpected: " << said;
  }
}

inline std::string WithReplaced(std::string text, const std::string& from,
                                const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "there is no " << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_CORE_IO_INPUT_ERROR_H_
