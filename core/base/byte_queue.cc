#include "core/base/byte_queue.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace kinegraph {
namespace {

using Length = uint32_t;
constexpr size_t kBlockBytes = size_t{256} << 10;

}  // namespace

void ByteQueue::Push(std::string_view thing) {
  const auto length = static_cast<Length>(thing.size());
  if (length != thing.size()) throw std::length_error("ByteQueue::Push");
  const size_t bytes = sizeof(length) + thing.size();
  if (blocks_.empty()) {
    blocks_.emplace_back();  // perhaps the only one, and small
  } else if (blocks_.back().size() + bytes > kBlockBytes) {
    blocks_.emplace_back().reserve(std::max(kBlockBytes, bytes));
  }
  std::string& block = blocks_.back();
  block.append(reinterpret_cast<const char*>(&length), sizeof(length));
  block.append(thing);
  ++size_;
}

std::string_view ByteQueue::front() const {
  const std::string_view block = blocks_.front();
  Length length = 0;
  std::memcpy(&length, block.data() + taken_, sizeof(length));
  return block.substr(taken_ + sizeof(length), length);
}

void ByteQueue::Pop() {
  taken_ += sizeof(Length) + front().size();
  --size_;
  if (taken_ < blocks_.front().size()) return;
  blocks_.pop_front();
  taken_ = 0;
}

}  // namespace kinegraph
