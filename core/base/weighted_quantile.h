// Quantiles of values that do not all count the same.
#ifndef KINEGRAPH_CORE_BASE_WEIGHTED_QUANTILE_H_
#define KINEGRAPH_CORE_BASE_WEIGHTED_QUANTILE_H_

#include <utility>
#include <vector>

namespace kinegraph {

// A value and its weight, which is not negative.
using WeightedValue = std::pair<double, double>;

// The least of the values at or below which `share` of the weight lies. There
// must be a value.
double WeightedQuantile(std::vector<WeightedValue> values, double share);

// The middle by weight: the mean of two neighbours where exactly half lies on
// either side. There must be a value.
double WeightedMedian(std::vector<WeightedValue> values);

// Of weights counted in bins, which has some: the place [bins] below which
// `share` of all, `total`, lies; a bin's weight lies evenly in it.
double BinnedQuantile(const std::vector<float>& weights, double total,
                      double share);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_WEIGHTED_QUANTILE_H_
