#include "core/io/text/words.h"

#include <cmath>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/files/text_file.h"

namespace kinegraph {

std::string_view Words::Next() {
  while (!rest_.empty() && IsBetween(rest_.front())) {
    line_ += rest_.front() == '\n' ? 1 : 0;
    rest_.remove_prefix(1);
  }
  size_t end = 0;
  while (end < rest_.size() && !IsBetween(rest_[end])) ++end;
  const std::string_view word = rest_.substr(0, end);
  rest_.remove_prefix(end);
  return word;
}

std::string_view Words::Need(const char* what) {
  const std::string_view word = Next();
  if (word.empty()) throw InputError("ends before " + std::string(what));
  return word;
}

void Words::Expect(const char* wanted) {
  const std::string_view word = Need(wanted);
  if (word != wanted) Fail(word, wanted);
}

double Words::Number(const char* what) {
  const std::string_view word = Need(what);
  const auto number = ParseNumber<double>(WithoutPlus(word));
  if (!number.has_value() || !std::isfinite(*number)) Fail(word, what);
  return *number;
}

int64_t Words::Integer(const char* what, int64_t low, int64_t high) {
  const std::string_view word = Need(what);
  const auto number = ParseNumber<int64_t>(WithoutPlus(word));
  if (number.has_value() && *number >= low && *number <= high) return *number;
  Fail(word, std::string(what) + ", a whole number from " +
                 std::to_string(low) + " to " + std::to_string(high));
}

void Words::Fail(std::string_view found, const std::string& expected) {
  throw InputError("found '" + Printable(std::string(found)) + "', expected " +
                   expected);
}

bool IsNumberTable(std::string_view text) {
  constexpr int kEnough = 64;  // words to check; readers check all
  Words words(text, WordBreak::kSpaceOrCommas);
  for (int i = 0; i < kEnough; ++i) {
    const std::string_view word = words.Next();
    if (word.empty()) return i > 0;
    if (!ParseNumber<double>(WithoutPlus(word))) return false;
  }
  return true;
}

std::vector<double> ReadNumberTable(const std::string& path, size_t count,
                                    const std::string& what) {
  const std::string text = ReadTextFile(path, kMaxSmallFileBytes);
  size_t found = 0;
  Words all(text, WordBreak::kSpaceOrCommas);
  while (!all.Next().empty()) ++found;
  if (found != count) {
    throw InputError(
        path, "",
        "found " + std::to_string(found) + " numbers, expected " + what);
  }
  std::vector<double> numbers;
  Words words(text, WordBreak::kSpaceOrCommas);
  Located(
      path, [&] { return words.Place(); },
      [&] {
        while (numbers.size() < count) {
          numbers.push_back(words.Number("a finite number"));
        }
      });
  return numbers;
}

}  // namespace kinegraph
