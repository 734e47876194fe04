// Synthetic signals and measures for tests of the classical filters.
#ifndef KINEGRAPH_TESTS_SUPPORT_SIGNALS_H_
#define KINEGRAPH_TESTS_SUPPORT_SIGNALS_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/tracking/estimator.h"

namespace kinegraph::testing {

// A frame at 25 Hz in which none of 17 joints was triangulated.
inline EstimatorFrame FailedFrame(int frame) {
  EstimatorFrame in;
  in.frame = frame;
  in.time = frame * TimeNs{40'000'000};
  in.inlier_views.assign(17, 0);
  return in;
}

// A frame in which three views give all joints the position x = `x_m`, y = 2
// `x_m`.
inline EstimatorFrame FrameAt(int frame, double x_m) {
  EstimatorFrame in = FailedFrame(frame);
  in.has_initial = true;
  Joint3d joint;
  joint.position_m = {x_m, 2.0 * x_m, 1.0};
  joint.status = JointStatus::kObserved;
  in.initial.assign(17, joint);
  in.triangulated.assign(17, 1);
  in.inlier_views.assign(17, 3);
  return in;
}

// The first `count` instants of a uniform clock [s].
inline std::vector<double> UniformTimes(int count, double rate_hz = 25.0) {
  std::vector<double> times_s(static_cast<size_t>(count));
  for (int k = 0; k < count; ++k) times_s[static_cast<size_t>(k)] = k / rate_hz;
  return times_s;
}

// An uneven clock of 25 Hz on average: np.sort(0.04 * k + 0.012 * np.sin(1.7 *
// k)).
inline std::vector<double> UnevenTimes(int count) {
  std::vector<double> times_s = UniformTimes(count);
  for (int k = 0; k < count; ++k) {
    times_s[static_cast<size_t>(k)] += 0.012 * std::sin(1.7 * k);
  }
  std::sort(times_s.begin(), times_s.end());
  return times_s;
}

// A wave, a drift and an oscillation at the Nyquist frequency: np.sin(0.3 * k)
// + 0.1 * k + 0.05 * (-1.0) ** k, k = np.arange(count).
inline Eigen::MatrixXd Wiggle(int count) {
  Eigen::MatrixXd values(count, 1);
  for (int k = 0; k < count; ++k) {
    values(k, 0) = std::sin(0.3 * k) + 0.1 * k + (k % 2 == 0 ? 0.05 : -0.05);
  }
  return values;
}

// A column of zeros, with a one in row `place` (Impulse) or ones from this row
// on (Step).
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

// Expects the values `expected` in the first column of the rows `places`.
inline void ExpectPlaces(const Eigen::MatrixXd& found,
                         const std::vector<int>& places,
                         const std::vector<double>& expected,
                         double tolerance) {
  ASSERT_EQ(places.size(), expected.size());
  for (size_t i = 0; i < places.size(); ++i) {
    EXPECT_NEAR(found(places[i], 0), expected[i], tolerance) << places[i];
  }
}

// The gain of a linear filter without phase shift for a cosine of the given
// frequency, a thousand samples from the ends.
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
