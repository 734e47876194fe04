// Smoothers that balance misfit against roughness: Whittaker-Henderson, the
// quintic smoothing spline, l1 trend filtering. Lambdas refer to time in
// frames, whatever the unit of `times`: a frame is the mean step between
// samples or, for Whittaker-Henderson, between all times.
#ifndef KINEGRAPH_SOLVERS_FILTERS_PENALISED_H_
#define KINEGRAPH_SOLVERS_FILTERS_PENALISED_H_

#include <memory>
#include <vector>

#include "solvers/filters/joint_segment.h"
#include "solvers/filters/smoothing_spline.h"

namespace kinegraph {

// Curves c(x) that minimise, for each column of the values y,
//   sum over samples |y_i - c_i|^2 + lambda (roughness of c).
class PenalisedCurve {
 public:
  virtual ~PenalisedCurve() = default;
  // The curve at the times given at construction. The derivatives of a spline
  // are written to `derivatives`; a curve defined only at these times has none.
  virtual Samples Fit(double lambda,
                      CurveDerivatives* derivatives = nullptr) const = 0;
  // The lambda that halves the amplitude of a wave of frequency `cutoff`, in
  // cycles per unit of time, far from the ends; and the inverse function.
  double LambdaOf(double cutoff) const {
    return LambdaOfFrames(cutoff * step_);
  }
  double CutoffOf(double lambda) const {
    return CutoffInFrames(lambda) / step_;
  }
  // The lambda by generalised cross-validation (Craven and Wahba 1979), all
  // columns together, for cut-offs from 1/1000 to one half of a cycle per
  // frame; MakeCubicSpline: as ChooseLambdaByGcv (smoothing_spline.h).
  virtual double BestLambda() const = 0;

 protected:
  explicit PenalisedCurve(double step) : step_(step) {}
  double step() const { return step_; }
  // Cut-offs in cycles per frame.
  virtual double LambdaOfFrames(double cutoff) const = 0;
  virtual double CutoffInFrames(double lambda) const = 0;

 private:
  double step_;
};

// The cubic spline of smoothing_spline.h. At least five samples.
std::unique_ptr<PenalisedCurve> MakeCubicSpline(
    const std::vector<double>& times, const std::vector<char>& sampled,
    const Samples& values);

// Whittaker 1923, Henderson 1924; Eilers 2003. The roughness is the sum of the
// squared differences of `order` (2 or 3). For non-uniform time it is the sum
// of the squared divided differences, scaled to derivatives of that order, each
// weighted by the time it spans divided by `order`. Both approximate the
// integral of the squared derivative. Frames without a sample have no misfit.
// Needs at least 2 `order` + 1 samples.
std::unique_ptr<PenalisedCurve> MakeWhittaker(int order,
                                              const std::vector<double>& times,
                                              const std::vector<char>& sampled,
                                              const Samples& values);

// The natural spline of degree five (Schoenberg 1964, Woltring 1986): the
// roughness is the integral of the squared third derivative. Solved over all
// B-splines on the samples' times; the optimum is a natural spline. Needs at
// least seven samples.
std::unique_ptr<PenalisedCurve> MakeQuinticSpline(
    const std::vector<double>& times, const std::vector<char>& sampled,
    const Samples& values);

// l1 trend filtering (Kim, Koh, Boyd and Gorinevsky 2009): for each column the
// z that minimises sum (y_i - z_i)^2 / 2 + lambda sum |change of z's slope per
// frame at i|, i.e. straight pieces with few kinks. Their primal-dual
// interior-point method on the dual, a quadratic program with bounds |u_i| <=
// lambda, starting at u = 0 for every column. lambda is in the unit of the
// values. Fewer than three values are unchanged.
Samples TrendFilter(double lambda, const std::vector<double>& times,
                    const Samples& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_PENALISED_H_
