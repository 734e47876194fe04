// A view of contiguous values (std::span is C++20).
#ifndef KINEGRAPH_CORE_BASE_SPAN_H_
#define KINEGRAPH_CORE_BASE_SPAN_H_

#include <cstddef>
#include <vector>

namespace kinegraph {

template <typename T>
class Span {
 public:
  constexpr Span() = default;
  constexpr Span(const T* data, size_t size) : data_(data), size_(size) {}
  // NOLINTNEXTLINE(google-explicit-constructor): as std::span.
  Span(const std::vector<T>& values)
      : data_(values.data()), size_(values.size()) {}

  constexpr const T* data() const { return data_; }
  constexpr size_t size() const { return size_; }
  constexpr bool empty() const { return size_ == 0; }
  constexpr const T& operator[](size_t index) const { return data_[index]; }
  constexpr const T* begin() const { return data_; }
  constexpr const T* end() const { return data_ + size_; }

 private:
  const T* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_SPAN_H_
