// Cubic splines, and smooth steps.
#ifndef KINEGRAPH_CORE_SYNTHETIC_SPLINE_H_
#define KINEGRAPH_CORE_SYNTHETIC_SPLINE_H_

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace kinegraph {

// Uniform cubic B-spline, smooth to the second derivative. Approximates its
// control points without passing through them, which smooths them; stays in
// their convex hull. Constant beyond the ends.
class UniformSpline {
 public:
  UniformSpline() = default;
  // Control point i is centred at begin_s + i step_s. At least one point.
  UniformSpline(double begin_s, double step_s,
                std::vector<Eigen::Vector3d> points)
      : begin_s_(begin_s), step_s_(step_s), points_(std::move(points)) {}

  Eigen::Vector3d At(double time_s) const {
    const double last = static_cast<double>(points_.size() - 1);
    const double x = std::clamp((time_s - begin_s_) / step_s_, 0.0, last);
    const auto i = static_cast<int64_t>(x);
    const double u = x - static_cast<double>(i);
    const double v = 1.0 - u;
    const double u2 = u * u;
    return (v * v * v * Point(i - 1) + (4.0 + 3.0 * u2 * (u - 2.0)) * Point(i) +
            (4.0 + 3.0 * v * v * (v - 2.0)) * Point(i + 1) +
            u2 * u * Point(i + 2)) /
           6.0;
  }

 private:
  const Eigen::Vector3d& Point(int64_t index) const {
    const auto last = static_cast<int64_t>(points_.size()) - 1;
    return points_[static_cast<size_t>(std::clamp<int64_t>(index, 0, last))];
  }

  double begin_s_ = 0.0;
  double step_s_ = 1.0;
  std::vector<Eigen::Vector3d> points_;
};

// Smallest-jerk step from 0 (x <= 0) to 1 (x >= 1): 10 x^3 - 15 x^4 + 6 x^5,
// the shape of natural reaching (Flash and Hogan 1985). Twice differentiable.
inline double SmoothStep(double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  return x * x * x * (10.0 + x * (6.0 * x - 15.0));
}

// Rises smoothly from 0 to 1 between `rise_s` and `top_s`, and falls back until
// `fall_s`.
inline double SmoothBump(double time_s, double rise_s, double top_s,
                         double fall_s) {
  if (time_s <= top_s) {
    return SmoothStep((time_s - rise_s) / (top_s - rise_s));
  }
  return 1.0 - SmoothStep((time_s - top_s) / (fall_s - top_s));
}

// Cubic spline through points at any times. Interpolates vectors of one size,
// each coordinate separately, with a continuous second derivative. The end
// condition is "not a knot": the first two intervals share one cubic, and so do
// the last two, so nothing is assumed about speed or acceleration there (de
// Boor, A Practical Guide to Splines, chapter IV). Three knots give a parabola,
// two a line.
class KnotSpline {
 public:
  KnotSpline() = default;
  // `times_s` must ascend strictly; `values` has one column per knot. At least
  // two.
  KnotSpline(std::vector<double> times_s, Eigen::MatrixXd values);

  double begin_s() const { return times_s_.front(); }
  double end_s() const { return times_s_.back(); }
  const std::vector<double>& times_s() const { return times_s_; }
  const Eigen::MatrixXd& values() const { return values_; }

  // Times outside the knots are clamped to the nearest end: no extrapolation.
  Eigen::VectorXd At(double time_s) const;

 private:
  std::vector<double> times_s_;
  Eigen::MatrixXd values_;
  Eigen::MatrixXd second_;  // second derivatives at the knots
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_SPLINE_H_
