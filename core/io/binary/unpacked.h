// How much compressed bytes may stand for.
#ifndef KINEGRAPH_CORE_IO_BINARY_UNPACKED_H_
#define KINEGRAPH_CORE_IO_BINARY_UNPACKED_H_

#include <cstdint>

namespace kinegraph {

// Deflate reaches 1032 times what is stored, where nothing but one value is.
// Coordinates of one person among 250 whom a file has room for, all others
// missing, reach 256 times; a little may be all one value.
constexpr uint64_t MostUnpackedBytes(uint64_t stored_bytes) {
  return (uint64_t{32} << 20) + 256 * stored_bytes;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_BINARY_UNPACKED_H_
