#include "core/io/text/names.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/text.h"

namespace kinegraph {
namespace {

constexpr const char* kDigits = "0123456789";

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Removes a leading run of digits from `text` and returns it without leading
// zeros.
std::string_view CutNumber(std::string_view* text) {
  std::string_view digits = text->substr(0, text->find_first_not_of(kDigits));
  text->remove_prefix(digits.size());
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return digits;
}

// The part of a file's name that may contain a frame number.
std::string_view BeforeEnd(std::string_view file_name) {
  const size_t keypoints = file_name.rfind("_keypoints");
  return file_name.substr(0, keypoints != std::string_view::npos
                                 ? keypoints
                                 : file_name.rfind('.'));
}

// Whether the name contains the seconds of a long-running clock, such as those
// since 1970, with decimals: "1305031102.175304.png".
bool HasSeconds(std::string_view name) {
  constexpr int kFewest = 9;  // digits: at least 1e8 s, three years
  int digits = 0;             // of the current run, without leading zeros
  for (size_t i = 0; i + 1 < name.size(); ++i) {
    if (name[i] == '.' && digits >= kFewest && IsDigit(name[i + 1])) {
      return true;
    }
    digits = !IsDigit(name[i])              ? 0
             : digits > 0 || name[i] != '0' ? digits + 1
                                            : 0;
  }
  return false;
}

// The kind of time or date that a too large frame number resembles.
std::string TimeLikeness(std::optional<int64_t> number) {
  if (!number.has_value()) return "a time in nanoseconds";
  const size_t digits = std::to_string(*number).size();
  if (digits == 13) return "a time in milliseconds since 1970";
  if (digits == 16) return "a time in microseconds since 1970";
  return "a date and time";
}

}  // namespace

std::optional<int64_t> LastInteger(std::string_view name) {
  const size_t last = name.find_last_of(kDigits);
  if (last == std::string_view::npos) return std::nullopt;
  std::string_view run = name.substr(0, last + 1);
  run.remove_prefix(run.find_last_not_of(kDigits) + 1);  // npos + 1 is 0
  const std::string_view digits = CutNumber(&run);
  if (digits.size() > 18) return std::nullopt;
  return ParseNumber<int64_t>(digits).value_or(0);
}

std::optional<int64_t> FrameOfFileName(std::string_view file_name) {
  return LastInteger(BeforeEnd(file_name));
}

int64_t FrameOfName(std::string_view file_name) {
  const std::string_view name = BeforeEnd(file_name);
  const std::optional<int64_t> number = LastInteger(name);
  const bool has_seconds = HasSeconds(name);
  if (number.has_value() && *number < kMostFrames && !has_seconds)
    return *number;
  const std::string fault =
      "'" + Printable(std::string(file_name)) + "' contains no frame number";
  if (name.find_first_of(kDigits) == std::string_view::npos) {
    throw InputError(fault);
  }
  throw InputError(fault + " but what looks like " +
                   (has_seconds ? "a time in seconds" : TimeLikeness(number)) +
                   kNumberByTime);
}

bool NaturalLess(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a;
  const std::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (IsDigit(a.front()) && IsDigit(b.front())) {
      const std::string_view number_a = CutNumber(&a);
      const std::string_view number_b = CutNumber(&b);
      if (number_a.size() != number_b.size()) {
        return number_a.size() < number_b.size();
      }
      if (number_a != number_b) return number_a < number_b;
      continue;
    }
    if (a.front() != b.front()) return a.front() < b.front();
    a.remove_prefix(1);
    b.remove_prefix(1);
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;  // "cam1" and "cam01"
}

}  // namespace kinegraph
