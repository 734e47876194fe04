#include "core/base/utf8.h"

namespace kinegraph {

Utf8Letter LetterAt(std::string_view text, size_t begin) {
  const auto byte = [&](size_t i) {
    return static_cast<unsigned char>(text[begin + i]);
  };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  if (lead < 0xc2 || lead > 0xf4) return {};
  const size_t size = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (text.size() - begin < size) return {};
  char32_t point = lead & (0xffu >> (size + 1));
  for (size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    point = point << 6 | (byte(i) & 0x3fu);
  }
  // Too long for what they say, or halves of pairs.
  constexpr char32_t kLeast[] = {0x80, 0x800, 0x10000};
  const bool half = point >= 0xd800 && point < 0xe000;
  if (point < kLeast[size - 2] || point > 0x10ffff || half) return {};
  return {point, size};
}

}  // namespace kinegraph
