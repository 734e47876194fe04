// One factor on all sigmas of a person, from the residuals.
#ifndef KINEGRAPH_SOLVERS_GRAPH_NOISE_SCALE_H_
#define KINEGRAPH_SOLVERS_GRAPH_NOISE_SCALE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Squared whitened residuals |r|^2 of a chain's frames `begin` .. `end` - 1 at
// its states, each divided by the share 1 - trace(J C J') / 2 that the
// estimate's own error leaves of it (C: covariances of the states). Appended to
// `squares`.
void CollectSquares(const JointChain& chain,
                    const std::vector<Matrix6d>& covariances, size_t begin,
                    size_t end, std::vector<double>* squares);

// The scale at which `squares` are those of standard normal 2-vectors, outliers
// aside: starts at the median and then takes the mean of those within three
// sigmas. Drawn towards 1 while there are few, bounded to 1/4 .. 4.
double EstimateNoiseScale(std::vector<double> squares);

// Multiplies all sigmas.
void ScaleSigmas(double scale, PersonProblem* problem);

// The scale as far as frames that left a window tell it. Keeps a bounded number
// of the newest residuals.
class CausalNoiseScale {
 public:
  double scale() const { return scale_; }

  // To be called each time frames become final. True the first time and every
  // fifth after it: the residuals of these frames are then to be given to Add.
  // Errors of neighbouring frames are alike, so that these tell nearly as much
  // as all.
  bool AwaitTurn();
  // `squares` come from CollectSquares of a problem whose sigmas the caller had
  // multiplied by `applied`; that factor is taken out again here.
  void Add(const std::vector<double>& squares, double applied);

 private:
  std::vector<double> squares_;  // of unscaled sigmas; a ring when full
  size_t next_ = 0;
  int64_t turns_ = 0;
  double scale_ = 1.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_NOISE_SCALE_H_
