// Damped Gauss-Newton over the chains of joints by block-tridiagonal sweeps,
// joints side by side in lanes.
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

// The arrays behind ChainLanes. Keeps its memory between calls.
class LaneProblem {
 public:
  // Chains with the frames of `problem`, no more than `lanes`, a multiple of
  // kLaneMultiple.
  void Load(const PersonProblem& problem,
            const std::vector<const JointChain*>& chains, size_t lanes);

  const ChainLanes& arrays() const { return arrays_; }
  size_t frames() const { return frames_; }
  size_t lanes() const { return lanes_; }
  // Where row `row` of an array begins.
  size_t Row(size_t row) const { return row * lanes_; }

  LaneBuffer& states() { return states_; }  // rows [frame * 6 + i]
  // What stands in `lane` of such rows.
  StateChain ChainOf(const LaneBuffer& rows, size_t lane) const;
  bool IsFinite(size_t lane) const;  // of its states
  // States and weights in `lane`, and what is gated, into the chain they came
  // from.
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
  // Of the frame at hand: a measurement of the slot, and its place in views_.
  struct Slot {
    const PixelMeasurement* measurement = nullptr;
    size_t view = 0;
  };
  std::vector<Slot> slots_;
  // Of every chain's measurements in turn, the place in arrays of views.
  std::vector<size_t> place_;
  std::vector<size_t> first_place_;  // one a chain
  LaneBuffer process_noise_, x_px_, y_px_, per_sigma_, information_, counts_,
      weights_, prior_root_, prior_root_stated_, prior_x0_, prior_b_, states_;
};

// Finds the minima that Ceres finds with the same factors (a test compares
// them), at the cost of a few sweeps. Each chain is solved as if it were alone,
// and has the same bits in any company and on any instruction set. Keeps its
// work space between calls; not for use by two threads at a time.
class ChainSolver {
 public:
  // Gates the measurements at the chains' states and runs the stages one after
  // the other from there. States receive the minimum, measurements whether they
  // are gated and their weights there. The chains have the frames of `problem`.
  // The reports stand until the next call.
  const std::vector<SolveReport>& Solve(const PersonProblem& problem,
                                        const SolveSchedule& schedule,
                                        const std::vector<JointChain*>& chains);

  // Covariances of the states of frames before `frame_end` at the chains'
  // states and weights, [chain][frame], position [m^2] first; `correction` as
  // InformationCorrection gives it. Empty for a chain whose information is not
  // positive definite.
  std::vector<std::vector<Matrix6d>> Covariances(
      const PersonProblem& problem,
      const std::vector<const JointChain*>& chains, double correction,
      size_t frame_end);

 private:
  // Chains that share a call of the kernel.
  static constexpr size_t kGroup = kLaneMultiple;

  // Of chains begin .. end - 1.
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
