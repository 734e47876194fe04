#include "solvers/block_tridiagonal/linear_chain.h"

#include <cmath>
#include <type_traits>

#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

// Adds weight J'J of a factor on one state, or on two of neighbouring frames.
template <typename Factor>
void AddInformation(const Linearised<Factor>& at,
                    const Keys<Factor::kKeys>& keys, double weight,
                    LinearChain* linear) {
  for (int i = 0; i < Factor::kKeys; ++i) {
    AddProduct(at.by_states[i], at.by_states[i], weight,
               linear->diagonal[keys[i].frame].data());
  }
  if constexpr (Factor::kKeys == 2) {
    AddProduct(at.by_states[0], at.by_states[1], weight,
               linear->upper[keys[0].frame].data());
  }
}

}  // namespace

void LinearChain::Reset(size_t frames, size_t measurements) {
  diagonal.assign(frames, Matrix6d::Zero());
  upper.assign(frames > 0 ? frames - 1 : 0, Matrix6d::Zero());
  gradient.assign(frames, State::Zero());
  weights.assign(measurements, 0.0);
  cost = 0.0;
}

bool Linearise(const std::vector<TimeNs>& times, const JointChain& chain,
               const StateChain& states, const SolveStage& stage,
               OwnPrior own_prior, LinearChain* linear) {
  linear->Reset(states.size(), chain.measurements.size());
  FactorWalk walk;
  walk.stage = stage;
  walk.priors = own_prior == OwnPrior::kCounts;
  const auto state_of = [&](const StateKey& key) {
    return states[key.frame].data();
  };
  const auto add = [&](const auto& factor, const auto& keys,
                       const Robustness& robustness) {
    Linearised<std::decay_t<decltype(factor)>> at;
    if (!LineariseFactor(factor, keys, state_of, &at)) return false;
    const LossValue loss = robustness.Evaluate(at.squared_norm());
    if (robustness.measurement >= 0) {
      linear->weights[robustness.measurement] = loss.first;
    }
    linear->cost += 0.5 * robustness.information * loss.rho;
    const double weight = robustness.information * loss.first;
    AddInformation(at, keys, weight, linear);
    for (size_t i = 0; i < keys.size(); ++i) {
      AddGradient(at.by_states[i], at.residual, weight,
                  linear->gradient[keys[i].frame].data());
    }
    return true;
  };
  return ForEachFactor(times, chain, 0, walk, add) &&
         std::isfinite(linear->cost);
}

void LineariseInformation(const std::vector<TimeNs>& times,
                          const JointChain& chain, double correction,
                          OwnPrior own_prior, LinearChain* linear) {
  linear->Reset(times.size(), chain.measurements.size());
  FactorWalk walk;
  walk.priors = own_prior == OwnPrior::kCounts;
  walk.stated = true;
  const auto state_of = [&](const StateKey& key) {
    return chain.states[key.frame].data();
  };
  const auto add = [&](const auto& factor, const auto& keys,
                       const Robustness& robustness) {
    Linearised<std::decay_t<decltype(factor)>> at;
    if (!LineariseFactor(factor, keys, state_of, &at)) return true;
    double weight = WeightAtEstimate(chain, robustness, at.squared_norm());
    if (robustness.measurement >= 0) {
      weight *= correction * robustness.information;
    }
    if (weight > 0.0) AddInformation(at, keys, weight, linear);
    return true;
  };
  ForEachFactor(times, chain, 0, walk, add);
}

}  // namespace kinegraph
