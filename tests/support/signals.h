// Made-up signals and measures for the tests of the classical filters.
#ifndef KINEGRAPH_TESTS_SUPPORT_SIGNALS_H_
#define KINEGRAPH_TESTS_SUPPORT_SIGNALS_H_

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace kinegraph::testing {

// count times of a clock [s].
inline std::vector<double> UniformTimes(int count, double rate_hz = 25.0) {
  std::vector<double> times_s(static_cast<size_t>(count));
  for (int k = 0; k < count; ++k) times_s[static_cast<size_t>(k)] = k / rate_hz;
  return times_s;
}

// A clock at 25 Hz that goes unevenly:
// np.sort(0.04 * k + 0.012 * np.sin(1.7 * k)).
inline std::vector<double> UnevenTimes(int count) {
  std::vector<double> times_s = UniformTimes(count);
  for (int k = 0; k < count; ++k) {
    times_s[static_cast<size_t>(k)] += 0.012 * std::sin(1.7 * k);
  }
  std::sort(times_s.begin(), times_s.end());
  return times_s;
}

// A wave, a drift and a jitter of the highest frequency:
// np.sin(0.3 * k) + 0.1 * k + 0.05 * (-1.0) ** k, k = np.arange(count).
inline Eigen::MatrixXd Wiggle(int count) {
  Eigen::MatrixXd values(count, 1);
  for (int k = 0; k < count; ++k) {
    values(k, 0) = std::sin(0.3 * k) + 0.1 * k + (k % 2 == 0 ? 0.05 : -0.05);
  }
  return values;
}

// Zeros and a one at `place`, or ones from there on.
inline Eigen::MatrixXd Impulse(int count, int place) {
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(count, 1);
  values(place, 0) = 1.0;
  return values;
}
inline Eigen::MatrixXd Step(int count, int place) {
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(count, 1);
  values.bottomRows(count - place).setOnes();
  return values;
}

// What a linear filter makes of a cosine of that frequency at its crest, far
// from the ends.
inline double Gain(
    const std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>& filter,
    double frequency_hz, double rate_hz) {
  constexpr int kHalf = 1000;
  Eigen::MatrixXd values(2 * kHalf + 1, 1);
  for (int k = -kHalf; k <= kHalf; ++k) {
    values(k + kHalf, 0) = std::cos(2.0 * M_PI * frequency_hz * k / rate_hz);
  }
  return filter(values)(kHalf, 0);
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_SIGNALS_H_
