// A queue for very many small things that wait as bytes, of which there may
// also be few.
#ifndef KINEGRAPH_CORE_BASE_BYTE_QUEUE_H_
#define KINEGRAPH_CORE_BASE_BYTE_QUEUE_H_

#include <cstddef>
#include <deque>
#include <string>
#include <string_view>

namespace kinegraph {

// Things lie one behind the other in blocks, which are not copied as it grows
// and go back to the system as soon as their last thing was taken: what is
// allocated one by one lies scattered among other memory instead, and keeps the
// pages around it.
class ByteQueue {
 public:
  // Not longer than 4 GB.
  void Push(std::string_view thing);
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  // The oldest thing; valid until the next call of another kind.
  std::string_view front() const;
  void Pop();

 private:
  std::deque<std::string> blocks_;  // of whole things, with their lengths
  size_t taken_ = 0;                // bytes of the first block
  size_t size_ = 0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_BYTE_QUEUE_H_
