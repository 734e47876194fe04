// Natural cubic smoothing spline with generalised cross-validation.
#ifndef KINEGRAPH_SOLVERS_FILTERS_SMOOTHING_SPLINE_H_
#define KINEGRAPH_SOLVERS_FILTERS_SMOOTHING_SPLINE_H_

#include <functional>
#include <vector>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// The function f that minimises, for each column,
//   sum_i |y_i - f(t_i)|^2 + lambda_s3 integral |f''(t)|^2 dt
// over the times of the values, evaluated at `at_s`: a natural cubic spline
// (Reinsch 1967; the banded equations of Green and Silverman, Nonparametric
// Regression and Generalized Linear Models, section 2.3). `times_s` ascend and
// may be non-uniform; the ends need no padding. lambda_s3 >= 0 [s^3]. Linear
// outside the times. Fewer than three values: the line through them, or the
// value. The derivatives of f at `at_s`, per s and s^2, are written if
// requested.
Samples SmoothingSpline(double lambda_s3, const std::vector<double>& times_s,
                        const Samples& values, const std::vector<double>& at_s,
                        Samples* velocities = nullptr,
                        Samples* accelerations = nullptr);

// Generalised cross-validation (Craven and Wahba 1979), all columns together:
//   n sum |y - f|^2 / trace(I - A)^2,
// with the trace from the central bands of the inverse (Hutchinson and de Hoog
// 1985), as in Woltring's GCVSPL (1986). Needs at least three values.
double GcvScore(double lambda_s3, const std::vector<double>& times_s,
                const Samples& values);

// The lambda [s^3] of the least GcvScore, for cut-offs by LambdaOfCutoff from
// 1/1000 of the mean sampling rate to twice that rate: a grid in steps of a
// tenth of a decade of lambda, then a golden-section search. The formula of the
// cut-off is that of densely sampled waves: at half the rate the spline still
// passes 67 % of the fastest wave, at twice the rate 99.8 %, so exact values
// are kept. Needs at least five values.
double ChooseLambdaByGcv(const std::vector<double>& times_s,
                         const Samples& values);

// Minimum of `score` between `low` and `high`: a grid of `step`, then a
// golden-section search between the neighbours of the best point, to 1e-6.
double LeastOnGrid(double low, double high, double step,
                   const std::function<double(double)>& score);

// The lambda [s^3] that halves the amplitude of a wave of `cutoff_hz` for
// values `step_s` apart, far from the ends and well below the sampling rate: 1
// / (step (2 pi f)^4), because the gain is then 1 / (1 + (f / cutoff)^4)
// (Craven and Wahba 1979).
double LambdaOfCutoff(double cutoff_hz, double step_s);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_SMOOTHING_SPLINE_H_
