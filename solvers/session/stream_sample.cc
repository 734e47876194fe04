#include "solvers/session/stream_sample.h"

#include <algorithm>

namespace kinegraph {

void StreamSample::Add(double value) {
  ++count_;
  if (values_.size() < size_) {
    values_.push_back(value);
    return;
  }
  const auto place = static_cast<size_t>(random_.Index(count_));
  if (place < size_) values_[place] = value;
}

double StreamSample::Quantile(double share) const {
  if (values_.empty()) return 0.0;
  std::vector<double> sorted = values_;
  std::sort(sorted.begin(), sorted.end());
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<size_t>(place);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  const double part = place - static_cast<double>(below);
  return (1.0 - part) * sorted[below] + part * sorted[above];
}

}  // namespace kinegraph
