#include "core/evaluation/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/constants.h"

namespace kinegraph {
namespace {

// Where quantile `q` of `count` ordered values lies: between rank `below` and
// the next, `between` of the way.
struct Rank {
  Rank(int64_t count, double q) {
    const double position = q * static_cast<double>(count - 1);
    below = static_cast<int64_t>(std::floor(position));
    below = std::clamp<int64_t>(below, 0, count - 1);
    between = position - static_cast<double>(below);
  }
  int64_t below;
  double between;
};

double Interpolate(double low, double high, double between) {
  return low + between * (high - low);
}

}  // namespace

double Share::fraction() const {
  if (total == 0) return kNan;
  return static_cast<double>(count) / static_cast<double>(total);
}

double Mean(const std::vector<double>& values) {
  if (values.empty()) return kNan;
  return std::accumulate(values.begin(), values.end(), 0.0) /
         static_cast<double>(values.size());
}

double StandardDeviation(const std::vector<double>& values) {
  const double mean = Mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  if (values.empty()) return kNan;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return kNan;
  const Rank rank(static_cast<int64_t>(values.size()), q);
  const auto at = values.begin() + rank.below;
  std::nth_element(values.begin(), at, values.end());
  if (rank.between == 0.0) return *at;
  return Interpolate(*at, *std::min_element(at + 1, values.end()),
                     rank.between);
}

double QuantileOfRepeated(const std::vector<double>& ascending,
                          const std::vector<int64_t>& upto, double q) {
  if (upto.empty() || upto.back() == 0) return kNan;
  const Rank rank(upto.back(), q);
  const auto value = [&](int64_t place) {
    const auto at = std::upper_bound(upto.begin(), upto.end(), place);
    return ascending[at - upto.begin()];
  };
  if (rank.between == 0.0) return value(rank.below);
  return Interpolate(value(rank.below), value(rank.below + 1), rank.between);
}

}  // namespace kinegraph
