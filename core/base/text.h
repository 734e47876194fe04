// Texts: their parts and letters, and how far two are apart.
#ifndef KINEGRAPH_CORE_BASE_TEXT_H_
#define KINEGRAPH_CORE_BASE_TEXT_H_

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace kinegraph {

// What stands before, between and behind the separators, be it nothing: one
// part more than there are separators.
std::vector<std::string> Split(const std::string& text, char separator);

// Whether `text` ends in `end` and is more than that.
bool EndsIn(std::string_view text, std::string_view end);

// `text` without the blanks at its ends.
std::string Trimmed(const std::string& text);

// The number that the whole of `text` is, without a plus sign; none where it is
// anything else, or beyond what Number holds.
template <typename Number>
std::optional<Number> ParseNumber(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end) return std::nullopt;
  return number;
}

// `text` without the plus sign that may begin it.
inline std::string_view WithoutPlus(std::string_view text) {
  return text.substr(!text.empty() && text.front() == '+' ? 1 : 0);
}

// `text` as HTML and XML show it, in elements and quoted attributes.
std::string HtmlText(const std::string& text);

// Levenshtein's distance: the least number of characters to insert, delete or
// replace that turns `a` into `b`. Takes time in proportion to both lengths.
size_t EditDistance(const std::string& a, const std::string& b);

struct Utf8Letter {
  std::optional<char32_t> point;  // none: the bytes are no UTF-8
  size_t size = 1;                // bytes it takes; 1 where there is none
};

// The letter of UTF-8 (RFC 3629) that begins at text[begin], which is there.
Utf8Letter LetterAt(std::string_view text, size_t begin);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_TEXT_H_
