// The factors of one joint's chain, linearised at given states.
#ifndef KINEGRAPH_SOLVERS_GRAPH_LINEAR_CHAIN_H_
#define KINEGRAPH_SOLVERS_GRAPH_LINEAR_CHAIN_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/graph/problem.h"

namespace kinegraph {

// Gauss-Newton system of a chain: diagonal blocks, blocks right of them,
// gradient; and what it costs there. N is the size of a state: 6 for position
// and velocity, 9 with acceleration.
template <int N>
struct LinearChainOf {
  std::vector<Eigen::Matrix<double, N, N>> diagonal;
  // The motion's, the same at any states.
  std::vector<Eigen::Matrix<double, N, N>> upper;
  std::vector<Eigen::Matrix<double, N, 1>> gradient;
  std::vector<double> weights;  // rho' of every measurement
  double cost = 0.0;

  void Resize(size_t frames, size_t measurements);
};
using LinearChain = LinearChainOf<kStateSize>;

// Fills `upper`, which does not change during a solve. `process_noise` is the
// power of the white noise on acceleration (N = 6) or jerk (N = 9).
template <int N>
void LineariseMotion(const std::vector<TimeNs>& times, double process_noise,
                     LinearChainOf<N>* linear);

// Fills the rest at `states`. `use_prior`: the chain's own prior counts.
// False where a measurement that is not gated has no image.
template <int N>
bool Linearise(const std::vector<TimeNs>& times, const JointChain& chain,
               const std::vector<Eigen::Matrix<double, N, 1>>& states,
               const SolveStage& stage, bool use_prior,
               LinearChainOf<N>* linear);

// Diagonal blocks of the information at the chain's states and stored weights,
// each observation's times `correction` (InformationCorrection of its loss).
template <int N>
void LineariseInformation(const std::vector<TimeNs>& times,
                          const JointChain& chain, double correction,
                          bool use_prior, LinearChainOf<N>* linear);

// A solve ended before it converged, with `step` as its last. Where that still
// moved a state by more than 5 cm there is no estimate to speak of: weights of
// that frame's measurements become 0. Returns the number of such frames.
int DoubtUnsettled(const std::vector<State>& step, const JointChain& chain,
                   std::vector<double>* weights);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_LINEAR_CHAIN_H_
