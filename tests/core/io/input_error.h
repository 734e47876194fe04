// The message of an InputError that a call must throw.
#ifndef KINEGRAPH_TESTS_CORE_IO_INPUT_ERROR_H_
#define KINEGRAPH_TESTS_CORE_IO_INPUT_ERROR_H_

#include <gtest/gtest.h>

#include <exception>
#include <string>

#include "core/base/error.h"

namespace kinegraph::testing {

// Fails the test when nothing or something else is thrown, or the message is
// not one line.
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

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_CORE_IO_INPUT_ERROR_H_
