#include "solvers/filters/moving_median.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

// The mean of the two in the middle when their number is even. Reorders.
double Median(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<long>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  if (values->size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values->begin(), middle));
}

// Calls visit(place, column, values of the window).
template <typename Visit>
void ForEachWindow(double window_s, WindowSide side,
                   const std::vector<double>& times_s, const Samples& values,
                   Visit visit) {
  // Frame times are rounded: a value at the rim of a centred window is in, one
  // a whole window before a trailing one is out.
  constexpr double kSlack_s = 1e-6;
  const bool centred = side == WindowSide::kCentred;
  const double back_s =
      centred ? 0.5 * window_s + kSlack_s : window_s - kSlack_s;
  const double ahead_s = centred ? back_s : 0.0;
  size_t first = 0;
  size_t end = 0;
  std::vector<double> window;
  for (size_t i = 0; i < times_s.size(); ++i) {
    while (first < i && times_s[first] < times_s[i] - back_s) ++first;
    end = std::max(end, i + 1);
    while (end < times_s.size() && times_s[end] <= times_s[i] + ahead_s) ++end;
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
      const double* column = values.col(c).data();
      window.assign(column + first, column + end);
      visit(static_cast<Eigen::Index>(i), c, &window);
    }
  }
}

}  // namespace

Samples MovingMedian(double window_s, WindowSide side,
                     const std::vector<double>& times_s,
                     const Samples& values) {
  Samples filtered = values;
  ForEachWindow(
      window_s, side, times_s, values,
      [&](Eigen::Index i, Eigen::Index c, std::vector<double>* window) {
        filtered(i, c) = Median(window);
      });
  return filtered;
}

Samples HampelFilter(double window_s, double threshold, WindowSide side,
                     const std::vector<double>& times_s,
                     const Samples& values) {
  // 1 / the 75th percentile of the standard normal distribution.
  constexpr double kMadToSigma = 1.482602218505602;
  Samples filtered = values;
  ForEachWindow(
      window_s, side, times_s, values,
      [&](Eigen::Index i, Eigen::Index c, std::vector<double>* window) {
        const double median = Median(window);
        for (double& value : *window) value = std::abs(value - median);
        const double sigma = kMadToSigma * Median(window);
        if (std::abs(values(i, c) - median) > threshold * sigma) {
          filtered(i, c) = median;
        }
      });
  return filtered;
}

Samples HampelMedian(const HampelMedianOptions& options,
                     const std::vector<double>& times_s,
                     const Samples& values) {
  return MovingMedian(
      options.median_window_s, options.side, times_s,
      HampelFilter(options.hampel_window_s, options.hampel_threshold,
                   options.side, times_s, values));
}

}  // namespace kinegraph
