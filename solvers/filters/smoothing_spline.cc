#include "solvers/filters/smoothing_spline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "solvers/filters/banded.h"

namespace kinegraph {
namespace {

// The second derivatives g at the inner times solve B g = Q'y, where B = R +
// lambda Q'Q; the values are y - lambda Q g. R is tridiagonal, Q'Q
// pentadiagonal. Time is in mean steps, to keep the numbers near one.
class SplineSystem {
 public:
  SplineSystem(const std::vector<double>& times_s, const Samples& values)
      : count_(values.rows()), step_s_(MeanStep(times_s)), h_(count_ - 1) {
    for (Eigen::Index i = 0; i + 1 < count_; ++i) {
      const size_t k = static_cast<size_t>(i);
      h_(i) = (times_s[k + 1] - times_s[k]) / step_s_;
    }
    const Eigen::Index inner = count_ - 2;
    Qy_.resize(inner, values.cols());
    for (Eigen::Index i = 0; i < inner; ++i) {
      const std::array<double, 3> q = Q(i);
      Qy_.row(i) = q[0] * values.row(i) + q[1] * values.row(i + 1) +
                   q[2] * values.row(i + 2);
    }
  }

  double step_s() const { return step_s_; }
  double h(Eigen::Index i) const { return h_(i); }

  // `lambda` in cubes of the mean step.
  void Factorise(double lambda) {
    lambda_ = lambda;
    const Eigen::Index inner = count_ - 2;
    factors_ = PentadiagonalFactors(inner);
    for (Eigen::Index i = 0; i < inner; ++i) {
      const std::array<double, 3> q = Q(i);
      const double diagonal = (h_(i) + h_(i + 1)) / 3.0 + lambda * Dot(q, q, 0);
      double first = 0.0;
      double second = 0.0;
      if (i + 1 < inner) first = h_(i + 1) / 6.0 + lambda * Dot(q, Q(i + 1), 1);
      if (i + 2 < inner) second = lambda * Dot(q, Q(i + 2), 2);
      factors_.SetRow(i, diagonal, first, second);
    }
  }

  // Second derivatives at the inner times, per squared step.
  Samples SecondDerivatives() const {
    Samples g = Qy_;
    factors_.Solve(&g);
    return g;
  }

  // lambda Q g: the part of the values that smoothing removes.
  Samples Residuals(const Samples& g) const {
    Samples residuals = Samples::Zero(count_, g.cols());
    for (Eigen::Index i = 0; i < g.rows(); ++i) {
      const std::array<double, 3> q = Q(i);
      for (int k = 0; k < 3; ++k) {
        residuals.row(i + k) += lambda_ * q[k] * g.row(i);
      }
    }
    return residuals;
  }

  // trace(I - A) = lambda trace(B^-1 Q'Q): needs only the five central
  // diagonals of B^-1, computed from the last to the first.
  double TraceOfResiduals() const {
    const Eigen::Index inner = count_ - 2;
    double trace = 0.0;
    // Entries (i, i + k) of B^-1 in the two rows below, k = 0, 1, 2.
    std::array<double, 3> next{};
    std::array<double, 3> after{};
    for (Eigen::Index i = inner - 1; i >= 0; --i) {
      std::array<double, 3> row{};
      row[2] = i + 2 < inner
                   ? -factors_.l1(i) * next[1] - factors_.l2(i) * after[0]
                   : 0.0;
      row[1] = i + 1 < inner
                   ? -factors_.l1(i) * next[0] - factors_.l2(i) * next[1]
                   : 0.0;
      row[0] = 1.0 / factors_.d(i) - factors_.l1(i) * row[1] -
               factors_.l2(i) * row[2];
      const std::array<double, 3> q = Q(i);
      trace += row[0] * Dot(q, q, 0);
      if (i + 1 < inner) trace += 2.0 * row[1] * Dot(q, Q(i + 1), 1);
      if (i + 2 < inner) trace += 2.0 * row[2] * Dot(q, Q(i + 2), 2);
      after = next;
      next = row;
    }
    return lambda_ * trace;
  }

  double Gcv(double lambda) {
    Factorise(lambda);
    const double trace = TraceOfResiduals();
    return static_cast<double>(count_) *
           Residuals(SecondDerivatives()).squaredNorm() / (trace * trace);
  }

 private:
  // Column i of Q: its entries in rows i, i + 1, i + 2.
  std::array<double, 3> Q(Eigen::Index i) const {
    const double before = 1.0 / h_(i);
    const double behind = 1.0 / h_(i + 1);
    return {before, -before - behind, behind};
  }

  // Scalar product of two columns of Q, the second `shift` to the right.
  static double Dot(const std::array<double, 3>& a,
                    const std::array<double, 3>& b, int shift) {
    double sum = 0.0;
    for (int k = shift; k < 3; ++k) sum += a[k] * b[k - shift];
    return sum;
  }

  Eigen::Index count_;
  double step_s_;
  Eigen::VectorXd h_;  // steps, in mean steps
  Samples Qy_;
  double lambda_ = 0.0;
  PentadiagonalFactors factors_{0};
};

double Cube(double x) { return x * x * x; }

// The natural cubic spline with values `f` and second derivatives `g` (zero at
// both ends), linear outside.
Samples Evaluate(const SplineSystem& system, const std::vector<double>& times_s,
                 const Samples& f, const Samples& g,
                 const std::vector<double>& at_s,
                 CurveDerivatives* derivatives) {
  const Eigen::Index last = f.rows() - 1;
  Samples second = Samples::Zero(f.rows(), f.cols());
  second.middleRows(1, last - 1) = g;
  Samples values(static_cast<Eigen::Index>(at_s.size()), f.cols());
  derivatives->first.resizeLike(values);
  derivatives->second.resizeLike(values);
  for (size_t k = 0; k < at_s.size(); ++k) {
    const auto above =
        std::upper_bound(times_s.begin() + 1, times_s.end() - 1, at_s[k]);
    const Eigen::Index i = above - times_s.begin() - 1;
    const double h = system.h(i);
    const double t =
        (at_s[k] - times_s[i]) / (system.step_s() * h);  // 0 .. 1 inside
    const double inside = std::clamp(t, 0.0, 1.0);
    const double s = 1.0 - inside;
    // Derivative by t at the nearest point inside.
    const Eigen::RowVectorXd slope =
        f.row(i + 1) - f.row(i) +
        h * h / 6.0 *
            ((1.0 - 3.0 * s * s) * second.row(i) +
             (3.0 * inside * inside - 1.0) * second.row(i + 1));
    const auto row = static_cast<Eigen::Index>(k);
    values.row(row) = s * f.row(i) + inside * f.row(i + 1) +
                      h * h / 6.0 *
                          ((Cube(s) - s) * second.row(i) +
                           (Cube(inside) - inside) * second.row(i + 1)) +
                      (t - inside) * slope;
    derivatives->first.row(row) = slope / (system.step_s() * h);
    derivatives->second.row(row) =
        (s * second.row(i) + inside * second.row(i + 1)) /
        (system.step_s() * system.step_s());
    if (t != inside) derivatives->second.row(row).setZero();
  }
  return values;
}

}  // namespace

Samples SmoothingSpline(double lambda_s3, const std::vector<double>& times_s,
                        const Samples& values, const std::vector<double>& at_s,
                        CurveDerivatives* derivatives) {
  SplineSystem system(times_s, values);
  system.Factorise(lambda_s3 / Cube(system.step_s()));
  const Samples g = system.SecondDerivatives();
  const Samples f = values - system.Residuals(g);
  CurveDerivatives unused;
  return Evaluate(system, times_s, f, g, at_s,
                  derivatives == nullptr ? &unused : derivatives);
}

double ChooseLambdaByGcv(const std::vector<double>& times_s,
                         const Samples& values) {
  SplineSystem system(times_s, values);
  const auto log_lambda = [](double cycles_per_step) {
    return -4.0 * std::log10(2.0 * M_PI * cycles_per_step);
  };
  const auto score = [&](double x) { return system.Gcv(std::pow(10.0, x)); };
  const double low = log_lambda(2.0);
  const double high = log_lambda(1e-3);
  return std::pow(10.0, LeastOnGrid(low, high, 0.1, score)) *
         Cube(system.step_s());
}

double LeastOnGrid(double low, double high, double step,
                   const std::function<double(double)>& score) {
  double best = low;
  double best_score = score(low);
  for (double x = low + step; x <= high; x += step) {
    const double here = score(x);
    if (here < best_score) {
      best_score = here;
      best = x;
    }
  }
  constexpr double kGolden = 0.6180339887498949;
  double a = std::max(low, best - step);
  double b = std::min(high, best + step);
  double left = b - kGolden * (b - a);
  double right = a + kGolden * (b - a);
  double left_score = score(left);
  double right_score = score(right);
  while (b - a > 1e-6) {
    if (left_score <= right_score) {
      b = std::exchange(right, left);
      right_score = left_score;
      left = b - kGolden * (b - a);
      left_score = score(left);
    } else {
      a = std::exchange(left, right);
      left_score = right_score;
      right = a + kGolden * (b - a);
      right_score = score(right);
    }
  }
  return 0.5 * (a + b);
}

}  // namespace kinegraph
