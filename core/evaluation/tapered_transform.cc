#include "core/evaluation/tapered_transform.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/base/constants.h"

namespace kinegraph {

TaperedTransform::TaperedTransform(int length, int first)
    : trend_(Eigen::VectorXd::LinSpaced(length, -0.5 * (length - 1),
                                        0.5 * (length - 1))) {
  Eigen::VectorXd window(length);
  for (int i = 0; i < length; ++i) {
    window[i] = 0.5 - 0.5 * std::cos(2.0 * kPi * (i + 0.5) / length);
  }
  const double scale = 1.0 / std::sqrt(length * window.squaredNorm());
  const int bins = std::max(0, length / 2 - first + 1);
  fourier_.resize(bins, length);
  for (int row = 0; row < bins; ++row) {
    const int bin = first + row;
    // Positive and negative frequencies; the bin at half the rate occurs once.
    const double folded = 2 * bin == length ? 1.0 : std::sqrt(2.0);
    for (int i = 0; i < length; ++i) {
      fourier_(row, i) =
          std::polar(folded * scale * window[i], -2.0 * kPi * bin * i / length);
    }
  }
}

Eigen::MatrixXcd TaperedTransform::operator()(Eigen::MatrixXd signals) const {
  signals.rowwise() -= signals.colwise().mean().eval();
  signals -= trend_ * (trend_.transpose() * signals) / trend_.squaredNorm();
  return fourier_ * signals;
}

}  // namespace kinegraph
