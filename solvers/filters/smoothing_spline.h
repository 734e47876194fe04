// Natural cubic smoothing spline with generalised cross-validation.
#ifndef KINEGRAPH_SOLVERS_FILTERS_SMOOTHING_SPLINE_H_
#define KINEGRAPH_SOLVERS_FILTERS_SMOOTHING_SPLINE_H_

#include <functional>
#include <vector>

#include "solvers/filters/joint_segment.h"

namespace kinegraph {

// First and second derivative of a curve at the times where it is evaluated,
// per unit of time and per its square.
struct CurveDerivatives {
  Samples first, second;
};

// The function f that minimises, for each column,
//   sum_i |y_i - f(t_i)|^2 + lambda_s3 integral |f''(t)|^2 dt
// over the times of the values, evaluated at `at_s`: a natural cubic spline
// (Reinsch 1967; the banded equations of Green and Silverman, Nonparametric
// Regression and Generalized Linear Models, section 2.3). `times_s` ascend and
// may be non-uniform; the ends need no padding. lambda_s3 >= 0 [s^3]. Linear
// outside the times. Needs at least three values. The derivatives of f at
// `at_s` are written if requested.
Samples SmoothingSpline(double lambda_s3, const std::vector<double>& times_s,
                        const Samples& values, const std::vector<double>& at_s,
                        CurveDerivatives* derivatives = nullptr);

// The lambda [s^3] of the least score of generalised cross-validation (Craven
// and Wahba 1979), all columns together:
//   n sum |y - f|^2 / trace(I - A)^2,
// with the trace from the central bands of the inverse (Hutchinson and de Hoog
// 1985), as in Woltring's GCVSPL (1986). For cut-offs f = (lambda
// step)^(-1/4) / (2 pi) from 1/1000 of the mean sampling rate to twice that
// rate: a grid in steps of a tenth of a decade of lambda, then a golden-section
// search. This formula holds for densely sampled waves: with f at half the
// rate the spline still passes 67 % of the fastest wave, with f at twice the
// rate 99.8 %, so that exact values are kept. Needs at least five values.
double ChooseLambdaByGcv(const std::vector<double>& times_s,
                         const Samples& values);

// The argument between `low` and `high` with the least `score`: a grid of
// `step`, then a golden-section search between the neighbours of the best
// point, to 1e-6.
double LeastOnGrid(double low, double high, double step,
                   const std::function<double(double)>& score);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_SMOOTHING_SPLINE_H_
