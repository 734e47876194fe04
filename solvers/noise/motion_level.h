// The level of process noise of a class of joints: one for the recording, and
// from frame to frame.
#ifndef KINEGRAPH_SOLVERS_NOISE_MOTION_LEVEL_H_
#define KINEGRAPH_SOLVERS_NOISE_MOTION_LEVEL_H_

#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/base/time.h"
#include "solvers/noise/filter_bank.h"

namespace kinegraph {

// ln of the level, over the usual power, that maximises the evidence of all
// frames together with a prior: standard deviation 1 around the usual power.
// Between levels by a parabola; a tenth of the usual power at least.
double RecordingLevel(const Levels& evidence);

// A Markov chain over the levels in continuous time: jumps to neighbouring
// levels whose rates make an Ornstein-Uhlenbeck process around the recording's
// level (standard deviation 1, time constant 0.5 s), and now and then, five
// seconds apart, to any level.
class LevelChain {
 public:
  using Vector = Eigen::Matrix<double, kLevelCount, 1>;
  using Matrix = Eigen::Matrix<double, kLevelCount, kLevelCount>;

  // `recording_level` as RecordingLevel gives it.
  explicit LevelChain(double recording_level);

  // What is believed before anything is seen.
  const Vector& stationary() const { return stationary_; }
  // Column i: where level i leads after `dt`. Valid until the next call; clocks
  // jitter by nanoseconds, and such steps are one.
  const Matrix& Transition(TimeNs dt);

 private:
  Matrix Exponential(double dt_s) const;

  Vector stationary_;
  Matrix rates_;                    // column sums are zero
  std::map<TimeNs, Matrix> known_;  // by dt
};

// How well each level explains a frame, the best one 1.
LevelChain::Vector Likelihood(const Levels& evidence);

// Beliefs from one frame to the next, and back: the forward-backward algorithm
// (Rabiner 1989). Beliefs are normalised.
LevelChain::Vector Believe(const LevelChain::Vector& predicted,
                           const LevelChain::Vector& likelihood);

// Mean of ln level under the beliefs of each frame, given the likelihoods of
// all of them, `seen`. `first` is what is believed of the first frame before it
// is seen.
std::vector<double> SmoothLevels(const LevelChain::Vector& first,
                                 const std::vector<TimeNs>& times,
                                 const std::vector<LevelChain::Vector>& seen,
                                 LevelChain* chain);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_MOTION_LEVEL_H_
