// Numbers as bytes. For core/io only.
#ifndef KINEGRAPH_CORE_IO_BINARY_BYTES_H_
#define KINEGRAPH_CORE_IO_BINARY_BYTES_H_

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace kinegraph {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "expected a little-endian machine: files are copies of memory");

// Appends the numbers in little-endian order.
template <typename... Values>
void AppendNumbers(std::string* bytes, Values... values) {
  static_assert((std::is_arithmetic_v<Values> && ...));
  (bytes->append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
}

// The little-endian number at an offset; all of its bytes must exist.
template <typename Value>
Value NumberAt(std::string_view bytes, size_t at) {
  Value value{};
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_BINARY_BYTES_H_
