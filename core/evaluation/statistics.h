// Small statistics that several measures share.
#ifndef KINEGRAPH_CORE_EVALUATION_STATISTICS_H_
#define KINEGRAPH_CORE_EVALUATION_STATISTICS_H_

#include <cstdint>
#include <vector>

namespace kinegraph {

// How many of how many.
struct Share {
  int64_t count = 0;
  int64_t total = 0;

  void Add(bool counted) {
    count += counted ? 1 : 0;
    ++total;
  }
  Share& operator+=(const Share& other) {
    count += other.count;
    total += other.total;
    return *this;
  }
  // NaN when there is nothing to count.
  double fraction() const;
  double percent() const { return 100.0 * fraction(); }
};

// NaN for no values.
double Mean(const std::vector<double>& values);
// Square root of the mean squared distance from the mean (divided by n, not
// n - 1); NaN for no values.
double StandardDeviation(const std::vector<double>& values);
// Quantile `q` in 0..1 with linear interpolation between order statistics, so
// that 0 gives the least and 1 the greatest value; NaN for no values.
double Quantile(std::vector<double> values, double q);
// The same of values that are ascending already and repeated: `upto`[i] is how
// often values 0 .. i were taken together. Equal to Quantile of the repeated
// values, without a copy.
double QuantileOfRepeated(const std::vector<double>& ascending,
                          const std::vector<int64_t>& upto, double q);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_STATISTICS_H_
