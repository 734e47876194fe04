// Quantiles of a stream of numbers.
#ifndef KINEGRAPH_SOLVERS_SESSION_STREAM_SAMPLE_H_
#define KINEGRAPH_SOLVERS_SESSION_STREAM_SAMPLE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/random.h"

namespace kinegraph {

// A fair sample of a stream of numbers of any length (Vitter's reservoir), the
// same one for the same stream.
class StreamSample {
 public:
  explicit StreamSample(size_t size = 256) : size_(size) {}
  void Add(double value);
  int64_t count() const { return count_; }  // of all numbers
  double Quantile(double share) const;      // 0 without values

 private:
  size_t size_;
  std::vector<double> values_;
  Random random_{1};
  int64_t count_ = 0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_STREAM_SAMPLE_H_
