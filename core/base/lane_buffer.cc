#include "core/base/lane_buffer.h"

#include <algorithm>
#include <cstdint>

namespace kinegraph {

void LaneBuffer::Reserve(size_t size) {
  constexpr size_t kAlignment = 64;  // bytes
  memory_.resize(size + kAlignment / sizeof(double));
  const auto address = reinterpret_cast<uintptr_t>(memory_.data());
  const uintptr_t over = address % kAlignment;
  aligned_ =
      memory_.data() + (over == 0 ? 0 : (kAlignment - over) / sizeof(double));
}

void LaneBuffer::Assign(size_t size, double value) {
  Reserve(size);
  std::fill(aligned_, aligned_ + size, value);
}

}  // namespace kinegraph
