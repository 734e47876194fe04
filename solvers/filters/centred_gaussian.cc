#include "solvers/filters/centred_gaussian.h"

#include <cmath>

namespace kinegraph {

Samples CentredGaussian(double sigma_s, const std::vector<double>& times_s,
                        const Samples& values) {
  constexpr double kRadius = 4.0;  // sigmas
  // A frame time is a rounded number of nanoseconds.
  const double reach_s = kRadius * sigma_s + 1e-6;
  Samples smoothed(values.rows(), values.cols());
  size_t first = 0;
  for (size_t i = 0; i < times_s.size(); ++i) {
    while (times_s[first] < times_s[i] - reach_s) ++first;
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(values.cols());
    double total = 0.0;
    for (size_t k = first;
         k < times_s.size() && times_s[k] <= times_s[i] + reach_s; ++k) {
      const double sigmas = (times_s[k] - times_s[i]) / sigma_s;
      const double weight = std::exp(-0.5 * sigmas * sigmas);
      sum += weight * values.row(static_cast<Eigen::Index>(k));
      total += weight;
    }
    smoothed.row(static_cast<Eigen::Index>(i)) = sum / total;
  }
  return smoothed;
}

}  // namespace kinegraph
