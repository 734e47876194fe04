#include "solvers/filters/savitzky_golay.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace kinegraph {
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

}  // namespace kinegraph
