#include "core/base/error.h"

#include <utility>

namespace kinegraph {
namespace {

std::string Join(const std::string& file, const std::string& where,
                 const std::string& message) {
  std::string line = file;
  if (!where.empty()) line += ": " + where;
  return line + ": " + message;
}

// A message stays on one line whatever a file name or a key contains.
std::string OneLine(const std::string& message) {
  return Printable(message, 1000);
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
  for (const char c : text) {
    if (shown.size() >= max_length) return shown + "...";
    const auto byte = static_cast<unsigned char>(c);
    shown += (byte < 0x20 || byte == 0x7f) ? '?' : c;
  }
  return shown;
}

}  // namespace kinegraph
