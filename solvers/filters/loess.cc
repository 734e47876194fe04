#include "solvers/filters/loess.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/weighted_quantile.h"

namespace kinegraph {

Samples Loess(int neighbours, int degree, int iterations,
              const std::vector<double>& times, const Samples& values,
              const std::vector<double>& at) {
  const auto count = static_cast<Eigen::Index>(times.size());
  const auto k = std::min<Eigen::Index>(neighbours, count);
  const auto fit = [&](const std::vector<double>& places,
                       const Eigen::VectorXd& robust) {
    Samples fitted(static_cast<Eigen::Index>(places.size()), values.cols());
    Eigen::Index first = 0;
    for (size_t i = 0; i < places.size(); ++i) {
      const double t = places[i];
      while (first + k < count && t - times[first] > times[first + k] - t) {
        ++first;
      }
      const double reach = std::max(t - times[first], times[first + k - 1] - t);
      Eigen::VectorXd weights(k);
      Eigen::MatrixXd powers(k, degree + 1);
      for (Eigen::Index j = 0; j < k; ++j) {
        const double x = reach > 0.0 ? (times[first + j] - t) / reach : 0.0;
        const double distance = std::abs(x);
        const double share = 1.0 - distance * distance * distance;
        weights(j) = std::max(0.0, share * share * share);
        powers(j, 0) = 1.0;
        for (int d = 1; d <= degree; ++d) powers(j, d) = x * powers(j, d - 1);
      }
      const Eigen::VectorXd both =
          weights.cwiseProduct(robust.segment(first, k));
      // If all values nearby are outliers, uses them with their plain weights.
      if (both.maxCoeff() > 0.0) weights = both;
      const auto roots = weights.cwiseSqrt().asDiagonal();
      // Centred at t: the polynomial's value is its first coefficient.
      fitted.row(static_cast<Eigen::Index>(i)) =
          (roots * powers)
              .colPivHouseholderQr()
              .solve(roots * values.middleRows(first, k))
              .row(0);
    }
    return fitted;
  };
  Eigen::VectorXd robust = Eigen::VectorXd::Ones(count);
  for (int i = 0; i < iterations; ++i) {
    const Eigen::VectorXd residuals =
        (values - fit(times, robust)).rowwise().norm();
    std::vector<WeightedValue> lengths;
    for (const double residual : residuals) lengths.emplace_back(residual, 1.0);
    const double limit = 6.0 * WeightedMedian(std::move(lengths));
    if (!(limit > 0.0)) break;  // at least half of the residuals are zero
    for (Eigen::Index j = 0; j < count; ++j) {
      const double share = std::min(1.0, residuals(j) / limit);
      robust(j) = (1.0 - share * share) * (1.0 - share * share);
    }
  }
  return fit(at, robust);
}

}  // namespace kinegraph
