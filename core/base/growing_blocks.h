// A queue for millions of small values of which there may also be few.
#ifndef KINEGRAPH_CORE_BASE_GROWING_BLOCKS_H_
#define KINEGRAPH_CORE_BASE_GROWING_BLOCKS_H_

#include <algorithm>
#include <cstddef>
#include <deque>
#include <vector>

namespace kinegraph {

// Grows without copying, in blocks each twice as large as the one before, up to
// 64 KB, and gives back each block as soon as its last value was taken. The
// small blocks of a std::deque lie scattered among those of others, and what
// is given back of them is of little use to anybody.
template <typename T>
class GrowingBlocks {
 public:
  void Push(const T& value) {
    if (blocks_.empty() || blocks_.back().size() == capacity_) AddBlock();
    blocks_.back().push_back(value);
  }
  bool empty() const { return blocks_.empty(); }
  // The oldest value.
  const T& front() const { return blocks_.front()[taken_]; }
  T& back() { return blocks_.back().back(); }
  void Pop() {
    if (++taken_ < blocks_.front().size()) return;
    blocks_.pop_front();
    taken_ = 0;
  }

 private:
  static constexpr size_t kFirst = 16;
  static constexpr size_t kMost =
      std::max<size_t>(kFirst, (size_t{64} << 10) / sizeof(T));

  void AddBlock() {
    capacity_ = blocks_.empty() ? kFirst : std::min(2 * capacity_, kMost);
    blocks_.emplace_back().reserve(capacity_);
  }

  std::deque<std::vector<T>> blocks_;  // none is empty
  size_t capacity_ = 0;                // of the last block
  size_t taken_ = 0;                   // of the first block
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_GROWING_BLOCKS_H_
