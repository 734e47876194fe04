#include "solvers/graph/problem.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "solvers/graph/factor_list.h"

namespace kinegraph {

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

void GateMeasurements(JointChain* chain) {
  for (size_t k = 0; k < chain->states.size(); ++k) {
    const double* states[] = {chain->states[k].data()};
    for (int32_t m = chain->first[k]; m < chain->first[k + 1]; ++m) {
      double residual[2];
      chain->measurements[m].gated = !ReprojectionOf(chain->measurements[m])
                                          .Evaluate(states, residual, nullptr);
    }
  }
}

void StoreWeights(const SolveStage& stage, JointChain* chain) {
  for (size_t k = 0; k < chain->states.size(); ++k) {
    const double* states[] = {chain->states[k].data()};
    for (int32_t m = chain->first[k]; m < chain->first[k + 1]; ++m) {
      PixelMeasurement& measurement = chain->measurements[m];
      double r[2];
      const bool counts =
          !measurement.gated &&
          ReprojectionOf(measurement).Evaluate(states, r, nullptr);
      measurement.weight = counts ? EvaluateLoss(stage.loss, stage.scale,
                                                 r[0] * r[0] + r[1] * r[1])
                                        .first
                                  : 0.0;
    }
  }
}

int DoubtUnsettled(const StateChain& step, JointChain* chain) {
  constexpr double kUnsettled = 0.05;  // m
  int count = 0;
  for (size_t k = 0; k < step.size(); ++k) {
    // NaN, which maxCoeff may pass over, counts as a large move.
    if ((step[k].head<3>().array().abs() < kUnsettled).all()) continue;
    ++count;
    for (int32_t m = chain->first[k]; m < chain->first[k + 1]; ++m) {
      chain->measurements[m].weight = 0.0;
    }
  }
  return count;
}

size_t PlacedFactor::first_frame() const {
  size_t first = keys.front().frame;
  for (const StateKey& key : keys) first = std::min(first, key.frame);
  return first;
}

size_t PlacedFactor::last_frame() const {
  size_t last = 0;
  for (const StateKey& key : keys) last = std::max(last, key.frame);
  return last;
}

std::vector<PlacedFactor> PlaceUserFactors(const UserFactorSource& source,
                                           const UserFrame& frame, size_t k,
                                           int joint_count) {
  constexpr char kWhere[] = "user factor";
  std::vector<PlacedFactor> placed;
  for (UserFactor& user : source(frame)) {
    if (user.factor == nullptr || user.states.empty() ||
        user.factor->state_count() != static_cast<int>(user.states.size())) {
      throw OptionError(kWhere, "found " + std::to_string(user.states.size()) +
                                    " states, expected as many as the factor "
                                    "depends on");
    }
    if (user.loss != LossKind::kNone && !(user.loss_scale > 0.0)) {
      throw OptionError(kWhere, "found loss_scale " +
                                    std::to_string(user.loss_scale) +
                                    ", expected more than 0");
    }
    PlacedFactor& place = placed.emplace_back();
    place.robustness.loss = user.loss;
    place.robustness.scale = user.loss_scale;
    for (const UserState& state : user.states) {
      if (state.joint < 0 || state.joint >= joint_count) {
        throw OptionError(kWhere, "found joint " + std::to_string(state.joint) +
                                      ", expected 0 to " +
                                      std::to_string(joint_count - 1));
      }
      const int furthest = frame.has_previous ? 1 : 0;
      if (state.frames_back < 0 || state.frames_back > furthest) {
        throw OptionError(
            kWhere, "found frames_back " + std::to_string(state.frames_back) +
                        ", expected 0 to " + std::to_string(furthest));
      }
      const StateKey key = {state.joint, k - state.frames_back};
      for (const StateKey& other : place.keys) {
        if (other.joint != key.joint || other.frame != key.frame) continue;
        throw OptionError(kWhere, "found a state of joint " +
                                      std::to_string(state.joint) +
                                      " twice, expected different states");
      }
      place.keys.push_back(key);
    }
    place.factor = std::move(user.factor);
  }
  return placed;
}

bool LineariseGeneral(const PlacedFactor& placed, const PersonProblem& problem,
                      GeneralRows* rows) {
  const int row_count = placed.factor->residual_count();
  rows->residual.resize(row_count);
  rows->by_states.resize(placed.keys.size());
  std::vector<const double*> states;
  std::vector<double*> jacobians;
  for (size_t i = 0; i < placed.keys.size(); ++i) {
    states.push_back(problem.At(placed.keys[i]));
    rows->by_states[i].resize(row_count, kStateSize);
    jacobians.push_back(rows->by_states[i].data());
  }
  if (!placed.factor->Evaluate(states.data(), rows->residual.data(),
                               jacobians.data())) {
    return false;
  }
  const double root =
      std::sqrt(placed.robustness.Evaluate(rows->residual.squaredNorm()).first);
  rows->residual *= root;
  for (auto& by_state : rows->by_states) by_state *= root;
  return true;
}

}  // namespace kinegraph
