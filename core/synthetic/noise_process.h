// Random processes in time, one value a frame, each started in its stationary
// state.
#ifndef KINEGRAPH_CORE_SYNTHETIC_NOISE_PROCESS_H_
#define KINEGRAPH_CORE_SYNTHETIC_NOISE_PROCESS_H_

#include <Eigen/Core>

#include "core/base/random.h"

namespace kinegraph {

// Independent numbers of unit variance.
Eigen::Vector2d NormalVector(Random* random);

// Something that is on with a given rate, in bursts of geometric length: a
// two-state Markov chain. It compares a hidden uniform number, redrawn now and
// then, with the rate, so the rate may change from frame to frame.
class MarkovBursts {
 public:
  // Whether it is on in the next frame. `mean_frames` is the mean length of a
  // burst; where it is shorter than that of independent frames,
  // 1 / (1 - rate), frames are independent.
  bool Step(double rate, double mean_frames, Random* random);

 private:
  double level_ = -1.0;  // none drawn yet
};

// Something that is on with a given rate, in bursts of exactly `frames` frames.
class FixedBursts {
 public:
  // `began` tells whether a burst begins in this frame (or was under way when
  // the first frame came).
  bool Step(double rate, int frames, Random* random, bool* began);

 private:
  bool started_ = false;
  int left_ = 0;
};

// First-order autoregressive Gaussian vector of unit variance.
class SlowGaussian {
 public:
  // `rho`: correlation of neighbouring frames.
  Eigen::Vector2d Step(double rho, Random* random);

 private:
  bool started_ = false;
  Eigen::Vector2d value_ = Eigen::Vector2d::Zero();
};

// Scale s of variance one in the mean (E s^2 = 1) that turns a unit Gaussian
// into a Student-t of unit variance: s^2 = (dof - 2) / (2 g) with a Gamma
// process g of shape dof / 2 (Lewis, McKenzie and Hugus 1989: beta-gamma
// autoregression).
class SlowStudentScale {
 public:
  // `degrees_of_freedom` > 2.
  double Step(double rho, double degrees_of_freedom, Random* random);

 private:
  double gamma_ = -1.0;  // none drawn yet
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_NOISE_PROCESS_H_
