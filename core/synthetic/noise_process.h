// Random processes in time, one value per frame, each started in its stationary
// state.
#ifndef KINEGRAPH_CORE_SYNTHETIC_NOISE_PROCESS_H_
#define KINEGRAPH_CORE_SYNTHETIC_NOISE_PROCESS_H_

#include <Eigen/Core>

#include "core/base/random.h"

namespace kinegraph {

// Two independent standard normal numbers.
Eigen::Vector2d NormalVector(Random* random);

// An event that is on in a given share (`rate`) of the frames, in bursts of
// geometric length: a two-state Markov chain. It compares a hidden uniform
// number, redrawn occasionally, with the rate, so the rate may change from
// frame to frame.
class MarkovBursts {
 public:
  // Whether it is on in the next frame. `mean_frames` is the mean length of a
  // burst; if it is shorter than that of independent frames, 1 / (1 - rate),
  // frames are independent.
  bool Step(double rate, double mean_frames, Random* random);

 private:
  double level_ = -1.0;  // none drawn yet
};

// An event that is on in a given share (`rate`) of the frames, in bursts of
// exactly `frames` frames.
class FixedBursts {
 public:
  // `began`: whether a burst begins in this frame (or was in progress at the
  // first frame).
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

// Scale s with E s^2 = 1 that turns a unit Gaussian into a Student-t of unit
// variance: s^2 = (dof - 2) / (2 g) with a Gamma process g of shape dof / 2
// (Lewis, McKenzie and Hugus 1989: beta-gamma autoregression).
class SlowStudentScale {
 public:
  // `rho`: correlation of g in neighbouring frames; `degrees_of_freedom` > 2.
  double Step(double rho, double degrees_of_freedom, Random* random);

 private:
  double gamma_ = -1.0;  // none drawn yet
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_NOISE_PROCESS_H_
