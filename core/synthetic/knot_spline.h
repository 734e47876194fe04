// Cubic spline through points at any times.
#ifndef KINEGRAPH_CORE_SYNTHETIC_KNOT_SPLINE_H_
#define KINEGRAPH_CORE_SYNTHETIC_KNOT_SPLINE_H_

#include <Eigen/Core>
#include <vector>

namespace kinegraph {

// Interpolates vectors of one size, each coordinate by itself, with a
// continuous second derivative. The ends are "not a knot": the first two
// intervals share one cubic, and so do the last two, so nothing is assumed
// about speed or acceleration there (de Boor, A Practical Guide to Splines,
// chapter IV). Three knots give a parabola, two a line.
class KnotSpline {
 public:
  KnotSpline() = default;
  // `times_s` ascend strictly; `values` has one column a knot. At least two.
  KnotSpline(std::vector<double> times_s, Eigen::MatrixXd values);

  double begin_s() const { return times_s_.front(); }
  double end_s() const { return times_s_.back(); }
  const std::vector<double>& times_s() const { return times_s_; }
  const Eigen::MatrixXd& values() const { return values_; }

  // A time outside the knots counts as the nearest end: nothing is
  // extrapolated.
  Eigen::VectorXd At(double time_s) const;

 private:
  std::vector<double> times_s_;
  Eigen::MatrixXd values_;
  Eigen::MatrixXd second_;  // second derivatives at the knots
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_KNOT_SPLINE_H_
