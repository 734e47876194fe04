// Text: splitting, numbers, escaping, UTF-8 characters, and the distance of two
// strings.
#ifndef KINEGRAPH_CORE_BASE_TEXT_H_
#define KINEGRAPH_CORE_BASE_TEXT_H_

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace kinegraph {

// The parts between separators, which may be empty: one part more than there
// are separators.
std::vector<std::string> Split(const std::string& text, char separator);

// Whether `text` ends in `end` and is longer than it.
bool EndsIn(std::string_view text, std::string_view end);
// The same for ASCII letters of either case: "WALK.TRC" ends in ".trc".
bool EndsInAnyCase(std::string_view text, std::string_view end);

// `text` without spaces, tabs and line breaks at its ends.
std::string Trimmed(const std::string& text);

// The number that all of `text` represents, without a plus sign; nullopt for
// anything else or a number out of range.
template <typename Number>
std::optional<Number> ParseNumber(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end) return std::nullopt;
  return number;
}

// `text` without a leading plus sign.
inline std::string_view WithoutPlus(std::string_view text) {
  return text.substr(!text.empty() && text.front() == '+' ? 1 : 0);
}

// A number of things: "1 frame", "2 frames". `one` and `many` may include a
// verb, as in "1 image is", "2 images are".
std::string Counted(int64_t count, const char* one, const char* many);

// `text` escaped for HTML and XML, in elements and quoted attributes.
std::string HtmlText(const std::string& text);

// The bytes in Base64 (RFC 4648).
std::string Base64(std::string_view bytes);

// Levenshtein distance: the least number of bytes to insert, delete or replace
// that turns `a` into `b`. The time is proportional to the product of both
// lengths.
size_t EditDistance(const std::string& a, const std::string& b);

struct Utf8Letter {
  std::optional<char32_t> point;  // none: not valid UTF-8
  size_t size = 1;                // in bytes; 1 if invalid
};

// The UTF-8 character (RFC 3629) at text[begin], which must exist.
Utf8Letter LetterAt(std::string_view text, size_t begin);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_TEXT_H_
