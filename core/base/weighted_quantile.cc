#include "core/base/weighted_quantile.h"

#include <algorithm>
#include <cstddef>

namespace kinegraph {
namespace {

// Index of the first of the ascending values at which the cumulative weight
// reaches a share of the total, and whether it equals that share.
struct Reached {
  size_t at = 0;
  bool exactly = false;
};

Reached Reach(const std::vector<WeightedValue>& ascending, double share) {
  double total = 0.0;
  for (const auto& [value, weight] : ascending) total += weight;
  const double wanted = share * total;
  double below = 0.0;
  for (size_t i = 0; i < ascending.size(); ++i) {
    below += ascending[i].second;
    if (below >= wanted) return {i, below == wanted};
  }
  return {ascending.size() - 1, false};
}

}  // namespace

double WeightedQuantile(std::vector<WeightedValue> values, double share) {
  std::sort(values.begin(), values.end());
  return values[Reach(values, share).at].first;
}

double WeightedMedian(std::vector<WeightedValue> values) {
  std::sort(values.begin(), values.end());
  const auto [at, exactly] = Reach(values, 0.5);
  return exactly && at + 1 < values.size()
             ? 0.5 * (values[at].first + values[at + 1].first)
             : values[at].first;
}

double BinnedQuantile(const std::vector<float>& weights, double total,
                      double share) {
  const double wanted = share * total;
  double below = 0.0;
  size_t bin = 0;
  while (bin + 1 < weights.size() && below + weights[bin] < wanted) {
    below += weights[bin++];
  }
  const double inside = std::max<double>(weights[bin], 1e-12);
  return static_cast<double>(bin) +
         std::clamp((wanted - below) / inside, 0.0, 1.0);
}

}  // namespace kinegraph
