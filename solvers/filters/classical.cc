#include "solvers/filters/classical.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace kinegraph {

// ---- Gaussian ----

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

// ---- One-Euro ----

namespace {

// Share of the new value in exponential smoothing with that cut-off.
double Alpha(double step_s, double cutoff_hz) {
  const double ratio = 2.0 * M_PI * cutoff_hz * step_s;
  return ratio / (ratio + 1.0);
}

}  // namespace

Samples OneEuro(const OneEuroOptions& options,
                const std::vector<double>& times_s, const Samples& values) {
  constexpr double kSpeedCutoffHz = 1.0;  // the paper's
  Samples filtered = values;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    double speed = 0.0;
    for (Eigen::Index i = 1; i < values.rows(); ++i) {
      const size_t k = static_cast<size_t>(i);
      const double step_s = times_s[k] - times_s[k - 1];
      const double last = filtered(i - 1, c);
      const double raw_speed = (values(i, c) - last) / step_s;
      speed += Alpha(step_s, kSpeedCutoffHz) * (raw_speed - speed);
      const double cutoff_hz =
          options.min_cutoff_hz + options.beta_per_m * std::abs(speed);
      filtered(i, c) = last + Alpha(step_s, cutoff_hz) * (values(i, c) - last);
    }
  }
  return filtered;
}

// ---- Savitzky-Golay ----

namespace {

// Row m: how much each of `length` values counts in the fitted polynomial's
// value at place m.
Eigen::MatrixXd SmoothingMatrix(int length, int order) {
  Eigen::MatrixXd powers(length, order + 1);
  const double half = std::max(0.5 * (length - 1), 0.5);
  for (int i = 0; i < length; ++i) {
    const double x = (i - 0.5 * (length - 1)) / half;  // -1 .. 1
    powers(i, 0) = 1.0;
    for (int k = 1; k <= order; ++k) powers(i, k) = x * powers(i, k - 1);
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(powers);
  const Eigen::MatrixXd Q =
      qr.householderQ() * Eigen::MatrixXd::Identity(length, order + 1);
  return Q * Q.transpose();
}

}  // namespace

int SavitzkyGolayLength(const SavitzkyGolayOptions& options, double rate_hz) {
  const double half = 0.5 * (options.window_s * rate_hz - 1.0);
  const int length = 2 * std::max(0, static_cast<int>(std::lround(half))) + 1;
  int least = static_cast<int>(options.order) + 1;
  if (least % 2 == 0) ++least;
  return std::max(length, least);
}

Samples SavitzkyGolay(int length, int order, const Samples& values) {
  const int count = static_cast<int>(values.rows());
  if (count == 0) return values;
  if (count < length) {
    return SmoothingMatrix(count, std::min(order, count - 1)) * values;
  }
  const Eigen::MatrixXd H = SmoothingMatrix(length, order);
  const int half = length / 2;
  Samples smoothed(count, values.cols());
  for (int i = half; i < count - half; ++i) {
    smoothed.row(i) = H.row(half) * values.middleRows(i - half, length);
  }
  smoothed.topRows(half) = H.topRows(half) * values.topRows(length);
  smoothed.bottomRows(half) = H.bottomRows(half) * values.bottomRows(length);
  return smoothed;
}

// ---- Moving median ----

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
  constexpr double kSlackS = 1e-6;
  const bool centred = side == WindowSide::kCentred;
  const double back_s = centred ? 0.5 * window_s + kSlackS : window_s - kSlackS;
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
