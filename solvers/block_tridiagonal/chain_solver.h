// Damped Gauss-Newton over the chains of joints by block-tridiagonal sweeps,
// one joint per SIMD lane.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_SOLVER_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_SOLVER_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "core/base/lane_buffer.h"
#include "core/base/pack.h"
#include "solvers/block_tridiagonal/chain_lanes.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// The arrays behind ChainLanes. Reuses its memory between calls.
class LaneProblem {
 public:
  // Loads at most `lanes` chains, which have the frames of `problem`; `lanes`
  // is a multiple of kLaneMultiple.
  void Load(const PersonProblem& problem,
            const std::vector<const JointChain*>& chains, size_t lanes);

  const ChainLanes& arrays() const { return arrays_; }
  size_t frames() const { return frames_; }
  size_t lanes() const { return lanes_; }
  // Index at which row `row` of an array begins.
  size_t Row(size_t row) const { return row * lanes_; }

  LaneBuffer& states() { return states_; }  // rows [frame * 6 + i]
  // The values of `lane` in rows like those of states().
  StateChain ChainOf(const LaneBuffer& rows, size_t lane) const;
  bool IsFinite(size_t lane) const;  // of the lane's states
  // Copies states, weights and gating of `lane` back into its chain.
  void Unload(size_t lane, JointChain* chain) const;

 private:
  void LoadTimes(const PersonProblem& problem,
                 const std::vector<const JointChain*>& chains);
  void LoadViews(const std::vector<const JointChain*>& chains);
  void LoadMeasurements(const std::vector<const JointChain*>& chains);
  void LoadPriors(const std::vector<const JointChain*>& chains);
  void LoadStates(const std::vector<const JointChain*>& chains);

  size_t frames_ = 0;
  size_t lanes_ = 0;
  ChainLanes arrays_;
  std::vector<double> dt_s_;
  std::vector<std::array<double, 4>> centres_;
  std::vector<int> first_view_;
  std::vector<LaneFrameView> views_;
  // A view slot (PixelMeasurement::view_slot) of the current frame: one of the
  // slot's measurements, and the view's index in views_.
  struct Slot {
    const PixelMeasurement* measurement = nullptr;
    size_t view = 0;
  };
  std::vector<Slot> slots_;
  // Index of each measurement, of all chains in turn, in the arrays
  // [views][lanes].
  std::vector<size_t> place_;
  std::vector<size_t> first_place_;  // one per chain
  LaneBuffer process_noise_, x_px_, y_px_, per_sigma_, information_, counts_,
      weights_, prior_root_, prior_root_stated_, prior_x0_, prior_b_, states_;
};

// Finds the same minima as Ceres with the same factors (a test compares them),
// at the cost of a few sweeps. Each chain is solved independently; its result
// is bitwise independent of the other chains and of the instruction set. Reuses
// its work space between calls; not thread-safe.
class ChainSolver {
 public:
  // Gates the measurements at the chains' states and runs the stages one after
  // the other. States receive the minimum, measurements their gating and their
  // weights at the minimum. A chain without a finite result keeps its states,
  // and its measurements get no weight. The chains must have the frames of
  // `problem`. The reports are valid until the next call.
  const std::vector<SolveReport>& Solve(const PersonProblem& problem,
                                        const SolveSchedule& schedule,
                                        const std::vector<JointChain*>& chains);

  // Covariances of the states of frames before `frame_end` at the chains'
  // states and weights, [chain][frame], position [m^2] first; `correction` as
  // from InformationCorrection. Empty for a chain whose information is not
  // positive definite.
  std::vector<std::vector<Matrix6d>> Covariances(
      const PersonProblem& problem,
      const std::vector<const JointChain*>& chains, double correction,
      size_t frame_end);

 private:
  // Number of chains per call of the kernel.
  static constexpr size_t kGroup = kLaneMultiple;

  // Loads chains begin .. end - 1.
  template <typename Chain>
  void Load(const PersonProblem& problem, const std::vector<Chain*>& chains,
            size_t begin, size_t end);
  std::vector<Matrix6d> CovariancesIn(size_t lane, size_t frame_end) const;
  SolveReport Unload(size_t lane, const SolveSchedule& schedule,
                     JointChain* chain);

  LaneProblem lanes_;
  std::vector<const JointChain*> group_;
  std::vector<LaneStage> stages_;
  std::vector<SolveReport> reports_;
  LaneBuffer steps_, finite_, converged_, iterations_, covariances_, known_,
      workspace_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_SOLVER_H_
