#include "core/base/error.h"

#include <utility>

#include "core/base/text.h"

namespace kinegraph {
namespace {

std::string Join(const std::string& file, const std::string& where,
                 const std::string& message) {
  std::string line = file;
  if (!where.empty()) line += ": " + where;
  return line + ": " + message;
}

// Keeps a message on one line, whatever a file name or key contains.
std::string OneLine(const std::string& message) {
  return Printable(message, 1000);
}

// Terminals interpret control characters, including U+0080 to U+009F.
bool IsControl(char32_t point) {
  return point < 0x20 || (point >= 0x7f && point < 0xa0);
}

}  // namespace

InputError::InputError(const std::string& message)
    : std::runtime_error(OneLine(message)) {}

InputError::InputError(const std::string& file, const std::string& where,
                       const std::string& message)
    : std::runtime_error(OneLine(Join(file, where, message))) {}

OptionError::OptionError(std::string key, const std::string& message)
    : std::runtime_error(OneLine(key + ": " + message)),
      key_(std::move(key)),
      message_(message) {}

std::string Printable(const std::string& text, size_t max_length) {
  std::string shown;
  for (size_t i = 0; i < text.size();) {
    if (shown.size() >= max_length) return shown + "...";
    const Utf8Letter letter = LetterAt(text, i);
    const bool can_be_shown = letter.point && !IsControl(*letter.point);
    shown += can_be_shown ? text.substr(i, letter.size) : "?";
    i += letter.size;
  }
  return shown;
}

}  // namespace kinegraph
