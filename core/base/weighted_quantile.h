// Quantiles of weighted values.
#ifndef KINEGRAPH_CORE_BASE_WEIGHTED_QUANTILE_H_
#define KINEGRAPH_CORE_BASE_WEIGHTED_QUANTILE_H_

#include <utility>
#include <vector>

namespace kinegraph {

// A value and its weight >= 0.
using WeightedValue = std::pair<double, double>;

// The least value at or below which at least `share` of the weight lies.
// `values` must not be empty.
double WeightedQuantile(std::vector<WeightedValue> values, double share);

// The weighted median: the mean of two neighbours where exactly half lies on
// either side. `values` must not be empty.
double WeightedMedian(std::vector<WeightedValue> values);

// For a histogram with at least one non-zero bin: the position [bins] below
// which `share` of the `total` weight lies, interpolated linearly within a bin.
double BinnedQuantile(const std::vector<float>& weights, double total,
                      double share);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_WEIGHTED_QUANTILE_H_
