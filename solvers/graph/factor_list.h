// A person's factors: the factors of each joint, from
// solvers/factors/factors.h, and the bones between joints, but not
// PersonProblem::prior and the user's factors, whose sizes vary. Covariances of
// coupled joints, marginalisation and the couplings of the block-tridiagonal
// solver iterate over this list, and Ceres takes its factors from it;
// solvers/block_tridiagonal/chain_kernel.h iterates over the joints' factors in
// packs instead.
//
// A visitor is called as
//   bool visit(const Factor& factor, const Keys<Factor::kKeys>& keys,
//              const Robustness& robustness)
// for each factor; returning false ends the iteration. `factor` is a temporary
// that points into the problem; a copy of it may be kept.
#ifndef KINEGRAPH_SOLVERS_GRAPH_FACTOR_LIST_H_
#define KINEGRAPH_SOLVERS_GRAPH_FACTOR_LIST_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "core/base/time.h"
#include "core/geometry/camera.h"
#include "solvers/factors/factors.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// A camera as the View of a reprojection factor over doubles.
struct CameraView {
  const Camera* camera = nullptr;  // outlives the factor

  bool Project(const double* point, double* px, double (*by_point)[3]) const {
    Matrix23d jacobian;
    const Eigen::Vector3d position(point[0], point[1], point[2]);
    if (!(camera->Depth(position) > kNearestDepthM)) return false;
    const std::optional<Eigen::Vector2d> image =
        camera->Project(position, by_point == nullptr ? nullptr : &jacobian);
    if (!image.has_value()) return false;
    for (int row = 0; row < 2; ++row) {
      px[row] = (*image)(row);
      if (by_point == nullptr) continue;
      for (int i = 0; i < 3; ++i) by_point[row][i] = jacobian(row, i);
    }
    return true;
  }
};

using CameraReprojection = Reprojection<double, CameraView>;

// Selects the factors that an iteration visits.
struct FactorWalk {
  SolveStage stage;  // the loss of reprojections
  // Only factors whose earliest state is before this frame.
  size_t end = static_cast<size_t>(-1);
  bool priors = true;  // of the joints
  // Use the priors' information for covariances (StatePrior::A_stated).
  bool stated = false;
};

inline CameraReprojection ReprojectionOf(const PixelMeasurement& measurement) {
  return {{measurement.camera},
          measurement.offset_s,
          {measurement.px.x() - measurement.bias_px.x(),
           measurement.px.y() - measurement.bias_px.y()},
          1.0 / measurement.sigma_px};
}

inline GaussianPrior<double> PriorOf(const StatePrior& prior, bool stated) {
  return {stated ? prior.A_stated.data() : prior.A.data(), prior.x0.data(),
          prior.b.data()};
}

// A joint's chain in the form that factors.h iterates over.
class JointFactors {
 public:
  JointFactors(const PersonProblem& problem, size_t joint,
               const FactorWalk& walk)
      : times_(problem.times),
        centres_(problem.centres),
        chain_(problem.joints[joint]),
        walk_(walk),
        pixels_{walk.stage.loss, walk.stage.scale} {}

  size_t frame_count() const { return chain_.states.size(); }
  bool HasPrior() const { return walk_.priors; }
  GaussianPrior<double> Prior() const {
    return PriorOf(chain_.prior, walk_.stated);
  }
  bool HasCentre(size_t k) const { return centres_[k].per_sigma > 0.0; }
  BodyCentre<double> Centre(size_t k) const {
    return {centres_[k].position_m.data(), centres_[k].per_sigma};
  }
  ConstantVelocity<double> Motion(size_t k) const {
    return {ToSeconds(times_[k + 1] - times_[k]), chain_.process_noise[k]};
  }
  int32_t PixelsBegin(size_t k) const { return chain_.first[k]; }
  int32_t PixelsEnd(size_t k) const { return chain_.first[k + 1]; }
  bool IsLeftOut(int32_t m) const { return chain_.measurements[m].gated; }
  CameraReprojection Pixel(int32_t m) const {
    return ReprojectionOf(chain_.measurements[m]);
  }
  Robustness Always() const { return {}; }
  Robustness CountingOf(int32_t m) const {
    Robustness pixel = pixels_;
    pixel.information = chain_.measurements[m].information;
    pixel.measurement = m;
    return pixel;
  }

 private:
  const std::vector<TimeNs>& times_;
  const std::vector<PersonCentre>& centres_;
  const JointChain& chain_;
  const FactorWalk& walk_;
  const Robustness pixels_;
};

// The factors of one joint.
template <typename Visit>
bool ForEachFactor(const PersonProblem& problem, size_t joint,
                   const FactorWalk& walk, Visit&& visit) {
  const JointFactors factors(problem, joint, walk);
  const size_t end = std::min(walk.end, factors.frame_count());
  for (size_t k = 0; k < end; ++k) {
    const auto with_keys = [&](const auto& factor,
                               const Robustness& robustness) {
      Keys<std::decay_t<decltype(factor)>::kKeys> keys;
      for (size_t i = 0; i < keys.size(); ++i) {
        keys[i] = {static_cast<int>(joint), k + i};
      }
      return visit(factor, keys, robustness);
    };
    if (!ForEachFactorOfFrame(factors, k, with_keys)) return false;
  }
  return true;
}

// The bones, which couple a person's joints.
template <typename Visit>
bool ForEachCoupling(const PersonProblem& problem, const FactorWalk& walk,
                     Visit&& visit) {
  const size_t end = std::min(walk.end, problem.times.size());
  for (const BoneConstraint& bone : problem.bones) {
    const BoneLength<double> factor = {bone.length_m, 1.0 / bone.sigma_m};
    for (size_t k = 0; k < end; ++k) {
      if (!visit(factor, Keys<2>{{{bone.a, k}, {bone.b, k}}}, Robustness{})) {
        return false;
      }
    }
  }
  return true;
}

// A factor's residuals and Jacobians at given states.
template <typename Factor>
struct Linearised {
  double residual[Factor::kResiduals];
  typename Factor::Jacobian by_states[Factor::kKeys];

  double squared_norm() const {
    double sum = 0.0;
    for (const double r : residual) sum += r * r;
    return sum;
  }
};

// Evaluates a factor at `state_of(key)` [6]; false where it is undefined.
template <typename Factor, typename StateOf>
bool LineariseFactor(const Factor& factor, const Keys<Factor::kKeys>& keys,
                     const StateOf& state_of, Linearised<Factor>* linear) {
  const double* states[Factor::kKeys];
  for (int i = 0; i < Factor::kKeys; ++i) states[i] = state_of(keys[i]);
  return factor.Evaluate(states, linear->residual, linear->by_states);
}

// Evaluates a factor at a problem's states.
template <typename Factor>
bool LineariseFactor(const Factor& factor, const Keys<Factor::kKeys>& keys,
                     const PersonProblem& problem, Linearised<Factor>* linear) {
  const auto state_of = [&](const StateKey& key) { return problem.At(key); };
  return LineariseFactor(factor, keys, state_of, linear);
}

// The weight rho' of a factor at the estimate. A measurement has its stored
// weight, which the solver may have set to zero.
inline double WeightAtEstimate(const JointChain& chain,
                               const Robustness& robustness,
                               double squared_norm) {
  return robustness.measurement >= 0
             ? chain.measurements[robustness.measurement].weight
             : robustness.Evaluate(squared_norm).first;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_FACTOR_LIST_H_
