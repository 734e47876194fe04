#include "solvers/filters/classical.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace kinegraph {

// ---- Gaussian ----

Samples CentredGaussian(double sigma_s, const std::vector<double>& times_s,
                        const Samples& values) {
  constexpr double kRadius = 4.0;  // sigmas
  // Frame times are rounded to nanoseconds.
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

// Weight of the new value in exponential smoothing with this cut-off.
double Alpha(double step_s, double cutoff_hz) {
  const double ratio = 2.0 * M_PI * cutoff_hz * step_s;
  return ratio / (ratio + 1.0);
}

}  // namespace

Samples OneEuro(const OneEuroOptions& options,
                const std::vector<double>& times_s, const Samples& values) {
  if (options.zero_phase) {
    OneEuroOptions pass = options;
    pass.zero_phase = false;
    std::vector<double> backwards_s;  // the same steps in reverse
    for (auto time = times_s.rbegin(); time != times_s.rend(); ++time) {
      backwards_s.push_back(times_s.back() - *time);
    }
    const Samples forwards = OneEuro(pass, times_s, values);
    return OneEuro(pass, backwards_s, forwards.colwise().reverse())
        .colwise()
        .reverse();
  }
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

// Row m: weight of each of `length` values in the fitted polynomial's value at
// place m.
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
  // Longer than any signal; twice as much is still an int.
  constexpr double kLongest = 1e8;
  const double half =
      std::min(kLongest, 0.5 * (options.window_s * rate_hz - 1.0));
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

// For an even number the mean of the middle two. Reorders `values`.
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
  // Frame times are rounded. A value at the edge of a centred window is inside;
  // a value exactly one trailing window before the current value is outside.
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

namespace {

// tan of half the digital angle: the analogue frequency that the bilinear
// transform maps to it.
double Prewarp(double frequency_hz, double rate_hz) {
  return std::tan(M_PI * frequency_hz / rate_hz);
}

// One pass in place, transposed direct form II, each section initially in
// steady state for the first value.
void RunThrough(const std::vector<FilterSection>& sections,
                Eigen::VectorXd* signal) {
  for (const FilterSection& s : sections) {
    const double first = (*signal)(0);
    double z1 = first * (1.0 - s.b0);
    double z2 = first * (s.b2 - s.a2);
    for (double& value : *signal) {
      const double in = value;
      value = s.b0 * in + z1;
      z1 = s.b1 * in - s.a1 * value + z2;
      z2 = s.b2 * in - s.a2 * value;
    }
  }
}

}  // namespace

std::vector<FilterSection> ButterworthLowPass(int order, double cutoff_hz,
                                              double rate_hz) {
  const double w = Prewarp(cutoff_hz, rate_hz);
  std::vector<FilterSection> sections;
  for (int k = 0; k < order / 2; ++k) {
    const double damping = 2.0 * std::sin(M_PI * (2 * k + 1) / (2.0 * order));
    const double a0 = 1.0 + damping * w + w * w;
    const double b0 = w * w / a0;
    sections.push_back({b0, 2.0 * b0, b0, 2.0 * (w * w - 1.0) / a0,
                        (1.0 - damping * w + w * w) / a0});
  }
  if (order % 2 == 1) {
    const double b0 = w / (1.0 + w);
    sections.push_back({b0, b0, 0.0, (w - 1.0) / (w + 1.0), 0.0});
  }
  return sections;
}

double TwoPassCutoff(int order, double cutoff_hz, double rate_hz) {
  // Both passes together have the gain 1 / (1 + r^2n), r the ratio of analogue
  // frequencies; it is 1 / sqrt(2) at r = (sqrt(2) - 1)^(1/2n).
  const double ratio = std::pow(std::sqrt(2.0) - 1.0, 0.5 / order);
  return std::atan(Prewarp(cutoff_hz, rate_hz) / ratio) * rate_hz / M_PI;
}

Samples FiltFilt(const std::vector<FilterSection>& sections,
                 const Samples& values, int padding) {
  const Eigen::Index count = values.rows();
  if (count < 2) return values;
  const Eigen::Index pad = std::min<Eigen::Index>(padding, count - 1);
  Samples filtered(count, values.cols());
  Eigen::VectorXd padded(count + 2 * pad);
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const auto column = values.col(c);
    padded.segment(pad, count) = column;
    for (Eigen::Index k = 1; k <= pad; ++k) {
      padded(pad - k) = 2.0 * column(0) - column(k);
      padded(pad + count - 1 + k) =
          2.0 * column(count - 1) - column(count - 1 - k);
    }
    for (int pass = 0; pass < 2; ++pass) {
      RunThrough(sections, &padded);
      padded.reverseInPlace();
    }
    filtered.col(c) = padded.segment(pad, count);
  }
  return filtered;
}

namespace {

// Filters the differences from value to value and sums them up again; the sum
// is shifted to the mean of the values. Fewer than three values are unchanged.
Samples OnSpeed(const std::function<Samples(const Samples&)>& filter,
                const Samples& values) {
  const Eigen::Index steps = values.rows() - 1;
  if (steps < 2) return values;
  Samples sums = Samples::Zero(values.rows(), values.cols());
  sums.bottomRows(steps) =
      filter(values.bottomRows(steps) - values.topRows(steps));
  for (Eigen::Index i = 1; i <= steps; ++i) sums.row(i) += sums.row(i - 1);
  return sums.rowwise() + (values.colwise().mean() - sums.colwise().mean());
}

// `sections` designs one pass for a cut-off.
LowPass TwoPasses(
    const ButterworthOptions& options, double rate_hz,
    std::function<std::vector<FilterSection>(double cutoff_hz)> sections) {
  LowPass low_pass;
  low_pass.rate_hz = rate_hz;
  const int padding = 3 * (static_cast<int>(options.order) + 1);
  low_pass.filter = [=, on = options.on, sections = std::move(sections)](
                        double cutoff_hz, const Samples& values) {
    const auto filter = [&](const Samples& signal) {
      return FiltFilt(sections(cutoff_hz), signal, padding);
    };
    return on == FilterSignal::kSpeed ? OnSpeed(filter, values)
                                      : filter(values);
  };
  return low_pass;
}

}  // namespace

LowPass ZeroPhaseButterworth(const ButterworthOptions& options,
                             double rate_hz) {
  const int order = static_cast<int>(options.order);
  const auto of_a_pass_hz = [=, correct = options.correct_cutoff](double hz) {
    return correct ? TwoPassCutoff(order, hz, rate_hz) : hz;
  };
  LowPass low_pass = TwoPasses(options, rate_hz, [=](double cutoff_hz) {
    return ButterworthLowPass(order, of_a_pass_hz(cutoff_hz), rate_hz);
  });
  low_pass.gain = [=](double frequency_hz, double cutoff_hz) {
    const double ratio = Prewarp(frequency_hz, rate_hz) /
                         Prewarp(of_a_pass_hz(cutoff_hz), rate_hz);
    return 1.0 / (1.0 + std::pow(ratio, 2.0 * order));
  };
  return low_pass;
}

LowPass ZeroPhaseCriticallyDamped(const ButterworthOptions& options,
                                  double rate_hz) {
  const int order = static_cast<int>(options.order);
  // The cut-off is the half-power frequency of both passes, or of one pass.
  const double passes = options.correct_cutoff ? 2.0 : 1.0;
  const double half = std::sqrt(std::pow(2.0, 1.0 / (passes * order)) - 1.0);
  LowPass low_pass = TwoPasses(options, rate_hz, [=](double cutoff_hz) {
    const double w = Prewarp(cutoff_hz, rate_hz) / half;
    const double b0 = w / (1.0 + w);
    return std::vector<FilterSection>(
        order, {b0, b0, 0.0, (w - 1.0) / (w + 1.0), 0.0});
  });
  low_pass.gain = [=](double frequency_hz, double cutoff_hz) {
    const double ratio =
        half * Prewarp(frequency_hz, rate_hz) / Prewarp(cutoff_hz, rate_hz);
    return std::pow(1.0 + ratio * ratio, -order);
  };
  return low_pass;
}

}  // namespace kinegraph
