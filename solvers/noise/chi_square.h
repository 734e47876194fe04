// Quantiles of the chi-square distribution.
#ifndef KINEGRAPH_SOLVERS_NOISE_CHI_SQUARE_H_
#define KINEGRAPH_SOLVERS_NOISE_CHI_SQUARE_H_

namespace kinegraph {

// The value below which a chi-square variable with `degrees_of_freedom` > 0
// lies with probability `share`, 0 < share < 1. Relative error below 1e-9.
double ChiSquareQuantile(double share, double degrees_of_freedom);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_CHI_SQUARE_H_
