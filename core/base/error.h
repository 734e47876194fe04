// Errors that a user can cause. The library throws them; only the programs in
// apps/ print them (one line on stderr, exit code 2).
#ifndef KINEGRAPH_CORE_BASE_ERROR_H_
#define KINEGRAPH_CORE_BASE_ERROR_H_

#include <stdexcept>
#include <string>

namespace kinegraph {

// Bad input: a missing file, a wrong shape, an unknown key. what() is one line.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message);
  // "file: where: message". `where` names a line, key, camera or frame and may
  // be empty.
  InputError(const std::string& file, const std::string& where,
             const std::string& message);
};

// An option, or another value passed by the caller, that cannot be used, alone
// or together with others: what() is "key: message". For keys of a file, the
// configuration reader adds file and line and throws InputError.
class OptionError : public std::runtime_error {
 public:
  OptionError(std::string key, const std::string& message);
  const std::string& key() const { return key_; }
  const std::string& message() const { return message_; }

 private:
  std::string key_;
  std::string message_;
};

// `text` on one line, safe to print: control characters and bytes that are not
// UTF-8 are replaced by '?', and text after the character that reaches
// `max_length` bytes by "...".
std::string Printable(const std::string& text, size_t max_length = 60);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_ERROR_H_
