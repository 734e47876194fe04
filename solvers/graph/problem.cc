#include "solvers/graph/problem.h"

#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

enum class Gated { kVisited, kSkipped };

// Calls `visit(measurement, valid, squared norm)` for each measurement of the
// chain at its states, those that are gated included or not.
template <typename Visit>
void ForEachMeasurement(Gated gated, JointChain* chain, const Visit& visit) {
  for (size_t k = 0; k < chain->states.size(); ++k) {
    const double* states[] = {chain->states[k].data()};
    for (int32_t m = chain->first[k]; m < chain->first[k + 1]; ++m) {
      PixelMeasurement& measurement = chain->measurements[m];
      if (measurement.gated && gated == Gated::kSkipped) continue;
      Eigen::Vector2d residual = Eigen::Vector2d::Zero();
      const bool valid = ReprojectionOf(measurement)
                             .Evaluate(states, residual.data(), nullptr);
      visit(&measurement, valid, residual.squaredNorm());
    }
  }
}

}  // namespace

StatePrior BirthPrior(const Eigen::Vector3d& centre, double sigma_m,
                      double sigma_mps) {
  StatePrior prior;
  prior.A.setZero();
  prior.A.diagonal().head<3>().setConstant(1.0 / sigma_m);
  prior.A.diagonal().tail<3>().setConstant(1.0 / sigma_mps);
  prior.x0.head<3>() = centre;
  prior.A_stated = prior.A;
  return prior;
}

Eigen::VectorXd PersonPrior::Residual(const PersonStates& states) const {
  Eigen::VectorXd away = -x0;
  for (size_t j = 0; j < states.size(); ++j) {
    away.segment<kStateSize>(kStateSize * j) += states[j][0];
  }
  return A * away + b;
}

PersonStates StatesOf(const PersonProblem& problem) {
  PersonStates states;
  for (const JointChain& chain : problem.joints) {
    states.push_back(chain.states);
  }
  return states;
}

void GateMeasurements(JointChain* chain) {
  ForEachMeasurement(Gated::kVisited, chain,
                     [](PixelMeasurement* measurement, bool valid, double) {
                       measurement->gated = !valid;
                       measurement->weight = 0.0;
                     });
}

void StoreWeights(const SolveStage& stage, JointChain* chain) {
  for (PixelMeasurement& measurement : chain->measurements) {
    measurement.weight = 0.0;
  }
  ForEachMeasurement(
      Gated::kSkipped, chain,
      [&](PixelMeasurement* measurement, bool valid, double squared_norm) {
        if (!valid) return;
        measurement->weight =
            EvaluateLoss(stage.loss, stage.scale, squared_norm).first;
      });
}

int DoubtUnsettled(const StateChain& step, JointChain* chain) {
  constexpr double kUnsettled = 0.05;  // m
  int count = 0;
  for (size_t k = 0; k < step.size(); ++k) {
    // Written so that a move that is no number counts too.
    if (step[k].head<3>().cwiseAbs().maxCoeff() < kUnsettled) continue;
    ++count;
    for (int32_t m = chain->first[k]; m < chain->first[k + 1]; ++m) {
      chain->measurements[m].weight = 0.0;
    }
  }
  return count;
}

}  // namespace kinegraph
