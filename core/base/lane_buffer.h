// Memory for numbers in SIMD lanes.
#ifndef KINEGRAPH_CORE_BASE_LANE_BUFFER_H_
#define KINEGRAPH_CORE_BASE_LANE_BUFFER_H_

#include <cstddef>
#include <vector>

namespace kinegraph {

// Numbers in rows of SIMD lanes, aligned for every instruction set.
class LaneBuffer {
 public:
  LaneBuffer() = default;
  LaneBuffer(LaneBuffer&&) = default;
  LaneBuffer& operator=(LaneBuffer&&) = default;

  double* data() { return aligned_; }
  const double* data() const { return aligned_; }
  double& operator[](size_t index) { return aligned_[index]; }
  double operator[](size_t index) const { return aligned_[index]; }
  // Makes room for `size` numbers, whose values are undefined.
  void Reserve(size_t size);
  void Assign(size_t size, double value);

 private:
  std::vector<double> memory_;
  double* aligned_ = nullptr;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_LANE_BUFFER_H_
