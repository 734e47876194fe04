// Letters of texts in UTF-8 (RFC 3629).
#ifndef KINEGRAPH_CORE_BASE_UTF8_H_
#define KINEGRAPH_CORE_BASE_UTF8_H_

#include <cstddef>
#include <optional>
#include <string_view>

namespace kinegraph {

struct Utf8Letter {
  std::optional<char32_t> point;  // none: the bytes are no UTF-8
  size_t size = 1;                // bytes it takes; 1 where there is none
};

// The letter that begins at text[begin]; begin < text.size().
Utf8Letter LetterAt(std::string_view text, size_t begin);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_UTF8_H_
