// The length of one bone from looks at it, and how much it varies.
#ifndef KINEGRAPH_SOLVERS_NOISE_BONE_LENGTH_FIT_H_
#define KINEGRAPH_SOLVERS_NOISE_BONE_LENGTH_FIT_H_

#include <vector>

#include "solvers/noise/bone_looks.h"

namespace kinegraph {

inline double Square(double x) { return x * x; }

// What looks say of a length, and how each of them deviates from it.
struct LengthFit {
  bool known = false;
  // A median of lengths; else, beside much noise, a mean of squared ones.
  bool is_median = true;
  double length_m = 0.0;
  // Below zero where looks vary less than their noise says.
  double spread_m2 = 0.0;
  double noise_m2 = 0.0;             // of a look's length, on average
  std::vector<double> deviations;    // of the looks, in sigmas
  std::vector<double> variances_m2;  // of their lengths, spread included
};

// Not known where every look is shorter than its noise. BoneSpreads says by
// which model. There must be a look.
LengthFit FitLength(const std::vector<BoneObservation>& looks);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_BONE_LENGTH_FIT_H_
