// Which states a factor sees, and how much it counts.
#ifndef KINEGRAPH_SOLVERS_GRAPH_STATE_KEY_H_
#define KINEGRAPH_SOLVERS_GRAPH_STATE_KEY_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "solvers/factors/jacobian.h"
#include "solvers/factors/loss.h"

namespace kinegraph {

struct StateKey {
  int joint = 0;
  size_t frame = 0;
};

// States that a factor sees, the earliest frame first.
template <int kCount>
using Keys = std::array<StateKey, kCount>;

// How a factor's squared residual s counts: 0.5 information rho(s).
struct Robustness {
  LossKind loss = LossKind::kNone;
  double scale = 1.0;
  double information = 1.0;
  // Of the chain's measurements, the one this is; -1 for other factors.
  int32_t measurement = -1;

  LossValue Evaluate(double s) const { return EvaluateLoss(loss, scale, s); }
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_STATE_KEY_H_
