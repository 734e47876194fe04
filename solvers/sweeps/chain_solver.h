// Damped Gauss-Newton over the chains of joints by block-tridiagonal sweeps,
// joints side by side in lanes.
#ifndef KINEGRAPH_SOLVERS_SWEEPS_CHAIN_SOLVER_H_
#define KINEGRAPH_SOLVERS_SWEEPS_CHAIN_SOLVER_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/pack.h"
#include "solvers/graph/problem.h"
#include "solvers/sweeps/chain_lanes.h"

namespace kinegraph {

// Numbers in rows of lanes, aligned for every instruction set.
class LaneBuffer {
 public:
  LaneBuffer() = default;
  LaneBuffer(LaneBuffer&&) = default;
  LaneBuffer& operator=(LaneBuffer&&) = default;

  double* data() { return aligned_; }
  const double* data() const { return aligned_; }
  double& operator[](size_t index) { return aligned_[index]; }
  double operator[](size_t index) const { return aligned_[index]; }
  // What it holds afterwards is undefined.
  void Reserve(size_t size);
  void Assign(size_t size, double value);

 private:
  std::vector<double> memory_;
  double* aligned_ = nullptr;
};

// Finds the minima that Ceres finds with the same factors (a test compares
// them), at the cost of a few sweeps. Each chain is solved as if it were alone,
// and has the same bits in any company and on any instruction set. Keeps its
// work space between calls; not for use by two threads at a time.
class ChainSolver {
 public:
  // Gates the measurements at the chains' states and runs the stages one after
  // the other from there. States receive the minimum, measurements whether they
  // are gated and their weights there. All chains have the frames of `times`.
  std::vector<SolveReport> Solve(const std::vector<TimeNs>& times,
                                 const SolveSchedule& schedule,
                                 const std::vector<JointChain*>& chains);
  SolveReport Solve(const std::vector<TimeNs>& times,
                    const SolveSchedule& schedule, JointChain* chain);

  // Covariances of the states of frames before `frame_end` at the chains'
  // states and weights, [chain][frame], position [m^2] first; `correction` as
  // InformationCorrection gives it. Empty for a chain whose information is not
  // positive definite.
  std::vector<std::vector<Matrix6d>> Covariances(
      const std::vector<TimeNs>& times,
      const std::vector<const JointChain*>& chains, double correction,
      size_t frame_end);

  // Of all frames of one chain; false where there are none.
  bool Covariances(const std::vector<TimeNs>& times, const JointChain& chain,
                   double correction, std::vector<Matrix6d>* covariances);

 private:
  // Chains that share a call of the kernel.
  static constexpr size_t kGroup = kLaneMultiple;

  void LoadTimes(const std::vector<TimeNs>& times,
                 const std::vector<const JointChain*>& chains);
  void LoadViews(const std::vector<const JointChain*>& chains);
  void LoadMeasurements(const std::vector<const JointChain*>& chains);
  void LoadPriors(const std::vector<const JointChain*>& chains);
  void LoadStates(const std::vector<const JointChain*>& chains);
  void Load(const std::vector<TimeNs>& times,
            const std::vector<const JointChain*>& chains);
  void SolveGroup(const std::vector<TimeNs>& times,
                  const SolveSchedule& schedule,
                  const std::vector<JointChain*>& chains,
                  std::vector<SolveReport>* reports);
  void CovariancesOfGroup(const std::vector<TimeNs>& times,
                          const std::vector<const JointChain*>& chains,
                          double correction, size_t frame_end,
                          std::vector<std::vector<Matrix6d>>* covariances);
  SolveReport Unload(size_t lane, const SolveSchedule& schedule,
                     JointChain* chain);

  static size_t Row(size_t row) { return row * kGroup; }

  size_t frames_ = 0;
  ChainLanes arrays_;
  std::vector<double> dt_s_;
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
      weights_, prior_A_, prior_A_stated_, prior_x0_, prior_b_, states_, steps_,
      finite_, converged_, iterations_, covariances_, known_, workspace_;
  StateChain step_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SWEEPS_CHAIN_SOLVER_H_
