// Factors of a user of the library on the states of a person's problem.
#ifndef KINEGRAPH_SOLVERS_GRAPH_PLACED_FACTOR_H_
#define KINEGRAPH_SOLVERS_GRAPH_PLACED_FACTOR_H_

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "solvers/graph/general_factor.h"
#include "solvers/graph/state_key.h"

namespace kinegraph {

// A user's factor on the states of a problem.
struct PlacedFactor {
  std::shared_ptr<const GeneralFactor> factor;
  std::vector<StateKey> keys;  // of one frame, or of two neighbouring ones
  Robustness robustness;

  size_t first_frame() const;
  size_t last_frame() const;
};

// What `source` says of a frame that is the problem's frame `k`. Throws
// OptionError for joints or frames that are not there, and where the number of
// states is not the factor's.
std::vector<PlacedFactor> PlaceUserFactors(const UserFactorSource& source,
                                           const UserFrame& frame, size_t k,
                                           int joint_count);

// A placed factor at states: whitened rows times the root of its weight.
struct GeneralRows {
  Eigen::VectorXd residual;
  std::vector<
      Eigen::Matrix<double, Eigen::Dynamic, kStateSize, Eigen::RowMajor>>
      by_states;
};

// `state_of(key)` gives the state [6]; false where the factor has no value.
bool LineariseGeneral(
    const PlacedFactor& placed,
    const std::function<const double*(const StateKey&)>& state_of,
    GeneralRows* rows);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_PLACED_FACTOR_H_
