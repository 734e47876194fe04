// Smoothers that weigh misfit against roughness: Whittaker-Henderson, the
// quintic smoothing spline, l1 trend filtering. Lambdas are those of values one
// frame apart, whatever the unit of time: the mean step between the times.
#ifndef KINEGRAPH_SOLVERS_FILTERS_PENALISED_H_
#define KINEGRAPH_SOLVERS_FILTERS_PENALISED_H_

#include <memory>
#include <vector>

#include "solvers/filters/joint_segment.h"

namespace kinegraph {

// Curves c(x) that minimise, for each column of the values y,
//   sum over samples |y_i - c_i|^2 + lambda |roughness of c|^2.
class PenalisedCurve {
 public:
  virtual ~PenalisedCurve() = default;
  // At the times that the curve was made with.
  virtual Samples Fit(double lambda) const = 0;
  // Generalised cross-validation (Craven and Wahba 1979), all columns together.
  virtual double Gcv(double lambda) const = 0;
  // The lambda that halves the amplitude of a wave of that frequency, in cycles
  // a unit of time, far from the ends; and back.
  double LambdaOf(double cutoff) const {
    return LambdaOfFrames(cutoff * step_);
  }
  double CutoffOf(double lambda) const {
    return CutoffInFrames(lambda) / step_;
  }
  // That of the least Gcv between cut-offs of 1/1000 and one half of a cycle a
  // frame.
  virtual double BestLambda() const;

 protected:
  explicit PenalisedCurve(double step) : step_(step) {}
  double step() const { return step_; }

 private:
  // In cycles a frame.
  virtual double LambdaOfFrames(double cutoff) const = 0;
  virtual double CutoffInFrames(double lambda) const = 0;

  double step_;
};

// The cubic spline of smoothing_spline.h. At least five samples.
std::unique_ptr<PenalisedCurve> MakeCubicSpline(
    const std::vector<double>& times, const std::vector<char>& sampled,
    const Samples& values);

// Whittaker 1923, Henderson 1924; Eilers 2003. The roughness is the sum of the
// squared differences of `order` (2 or 3), on uneven time of divided
// differences, each weighted by the time it spans over `order`, so that both
// are the integral of the squared derivative. Frames without sample have no
// misfit. At least 2 `order` + 1 samples.
std::unique_ptr<PenalisedCurve> MakeWhittaker(int order,
                                              const std::vector<double>& times,
                                              const std::vector<char>& sampled,
                                              const Samples& values);

// The natural spline of degree five (Schoenberg 1964, Woltring 1986): the
// roughness is the integral of the squared third derivative. Solved over all
// B-splines on the samples' times, of which the natural ones are the best. At
// least seven samples.
std::unique_ptr<PenalisedCurve> MakeQuinticSpline(
    const std::vector<double>& times, const std::vector<char>& sampled,
    const Samples& values);

// l1 trend filtering (Kim, Koh, Boyd and Gorinevsky 2009): for each column the
// z that minimises sum (y_i - z_i)^2 / 2 + lambda sum |change of z's slope a
// frame at i|, so straight pieces with few kinks. Their primal-dual interior
// point method on the dual, a quadratic program with bounds
// |u_i| <= lambda; it starts at u = 0 for every column. lambda in the unit of
// the values.
Samples TrendFilter(double lambda, const std::vector<double>& times,
                    const Samples& values);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_PENALISED_H_
