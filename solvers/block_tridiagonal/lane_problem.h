// Chains of joints laid side by side in lanes.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_LANE_PROBLEM_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_LANE_PROBLEM_H_

#include <cstddef>
#include <vector>

#include "core/base/lane_buffer.h"
#include "solvers/block_tridiagonal/chain_lanes.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// The arrays behind ChainLanes. Keeps its memory between calls.
class LaneProblem {
 public:
  // All chains have the frames of `times`, and are no more than `lanes`, a
  // multiple of kLaneMultiple.
  void Load(const std::vector<TimeNs>& times,
            const std::vector<const JointChain*>& chains, size_t lanes);

  const ChainLanes& arrays() const { return arrays_; }
  size_t frames() const { return frames_; }
  size_t lanes() const { return lanes_; }
  // Where row `row` of an array begins.
  size_t Row(size_t row) const { return row * lanes_; }

  LaneBuffer& states() { return states_; }  // rows [frame * 6 + i]
  // States and weights in `lane`, and what is gated, into the chain they came
  // from.
  void UnloadStates(size_t lane, JointChain* chain) const;
  void UnloadWeights(size_t lane, JointChain* chain) const;

 private:
  void LoadTimes(const std::vector<TimeNs>& times,
                 const std::vector<const JointChain*>& chains);
  void LoadViews(const std::vector<const JointChain*>& chains);
  void LoadMeasurements(const std::vector<const JointChain*>& chains);
  void LoadPriors(const std::vector<const JointChain*>& chains);
  void LoadStates(const std::vector<const JointChain*>& chains);

  size_t frames_ = 0;
  size_t lanes_ = 0;
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
      weights_, prior_A_, prior_A_stated_, prior_x0_, prior_b_, states_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_LANE_PROBLEM_H_
