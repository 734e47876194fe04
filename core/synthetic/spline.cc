#include "core/synthetic/spline.h"

namespace kinegraph {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Slope of interval i.
VectorXd SlopeOf(const std::vector<double>& times, const MatrixXd& values,
                 Index i) {
  return (values.col(i + 1) - values.col(i)) /
         (times[static_cast<size_t>(i) + 1] - times[static_cast<size_t>(i)]);
}

// Second derivatives at the knots, of which there are at least four. At the
// inner knots they solve a tridiagonal system; at the two ends they are
// extrapolated linearly from the two nearest knots, the "not a knot" condition.
MatrixXd SecondDerivatives(const std::vector<double>& times,
                           const MatrixXd& values) {
  const Index last = values.cols() - 1;
  const auto h = [&times](Index i) {
    const auto at = static_cast<size_t>(i);
    return times[at + 1] - times[at];
  };
  MatrixXd second = MatrixXd::Zero(values.rows(), values.cols());
  VectorXd upper = VectorXd::Zero(values.cols());
  for (Index i = 1; i < last; ++i) {
    double below = h(i - 1);
    double diagonal = 2.0 * (h(i - 1) + h(i));
    double above = h(i);
    if (i == 1) {
      diagonal += h(0) * (h(0) + h(1)) / h(1);
      above -= h(0) * h(0) / h(1);
      below = 0.0;
    }
    if (i == last - 1) {
      diagonal += h(i) * (h(i) + h(i - 1)) / h(i - 1);
      below -= h(i) * h(i) / h(i - 1);
      above = 0.0;
    }
    const double pivot = diagonal - below * upper(i - 1);
    upper(i) = above / pivot;
    second.col(i) =
        (6.0 * (SlopeOf(times, values, i) - SlopeOf(times, values, i - 1)) -
         below * second.col(i - 1)) /
        pivot;
  }
  for (Index i = last - 2; i >= 1; --i) {
    second.col(i) -= upper(i) * second.col(i + 1);
  }
  second.col(0) = second.col(1) - h(0) / h(1) * (second.col(2) - second.col(1));
  second.col(last) =
      second.col(last - 1) +
      h(last - 1) / h(last - 2) * (second.col(last - 1) - second.col(last - 2));
  return second;
}

}  // namespace

KnotSpline::KnotSpline(std::vector<double> times_s, MatrixXd values)
    : times_s_(std::move(times_s)), values_(std::move(values)) {
  const Index count = values_.cols();
  if (count > 3) {
    second_ = SecondDerivatives(times_s_, values_);
    return;
  }
  second_ = MatrixXd::Zero(values_.rows(), count);
  if (count == 3) {
    const VectorXd parabola =
        2.0 * (SlopeOf(times_s_, values_, 1) - SlopeOf(times_s_, values_, 0)) /
        (times_s_[2] - times_s_[0]);
    second_.colwise() = parabola;
  }
}

VectorXd KnotSpline::At(double time_s) const {
  const double time = std::clamp(time_s, begin_s(), end_s());
  const auto next = std::upper_bound(times_s_.begin(), times_s_.end(), time);
  const Index i = std::min<Index>(next - times_s_.begin() - 1,
                                  static_cast<Index>(times_s_.size()) - 2);
  const double begin = times_s_[static_cast<size_t>(i)];
  const double h = times_s_[static_cast<size_t>(i) + 1] - begin;
  const double u = (time - begin) / h;
  const double v = 1.0 - u;
  return v * values_.col(i) + u * values_.col(i + 1) -
         h * h / 6.0 *
             (v * (1.0 - v * v) * second_.col(i) +
              u * (1.0 - u * u) * second_.col(i + 1));
}

}  // namespace kinegraph
