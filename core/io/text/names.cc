#include "core/io/text/names.h"

#include <algorithm>
#include <charconv>

namespace kinegraph {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Cuts a run of digits off the front of `text` and returns it without leading
// zeros.
std::string_view CutNumber(std::string_view* text) {
  size_t length = 0;
  while (length < text->size() && IsDigit((*text)[length])) ++length;
  std::string_view digits = text->substr(0, length);
  text->remove_prefix(length);
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return digits;
}

}  // namespace

std::optional<int64_t> LastInteger(std::string_view name) {
  size_t end = name.size();
  while (end > 0 && !IsDigit(name[end - 1])) --end;
  if (end == 0) return std::nullopt;
  size_t begin = end;
  while (begin > 0 && IsDigit(name[begin - 1])) --begin;
  std::string_view run = name.substr(begin, end - begin);
  const std::string_view digits = CutNumber(&run);
  if (digits.size() > 18) return std::nullopt;
  int64_t value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return value;
}

std::optional<int64_t> FrameOfFileName(std::string_view file_name) {
  const size_t keypoints = file_name.rfind("_keypoints");
  if (keypoints != std::string_view::npos) {
    return LastInteger(file_name.substr(0, keypoints));
  }
  return LastInteger(file_name.substr(0, file_name.rfind('.')));
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
