#include "core/synthetic/noise_process.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {

Eigen::Vector2d NormalVector(Random* random) {
  const double x = random->Normal();
  return {x, random->Normal()};
}

bool MarkovBursts::Step(double rate, double mean_frames, Random* random) {
  // A burst ends when the level is redrawn (probability q) and lands above the
  // rate: its mean length is 1 / (q (1 - rate)).
  const double redraw = mean_frames * (1.0 - rate) > 1.0
                            ? 1.0 / (mean_frames * (1.0 - rate))
                            : 1.0;
  const bool draw = random->Chance(redraw);
  const double fresh = random->Uniform();
  if (draw || level_ < 0.0) level_ = fresh;
  return level_ < rate;
}

bool FixedBursts::Step(double rate, int frames, Random* random, bool* began) {
  *began = false;
  if (left_ > 0) {
    --left_;
    return true;
  }
  const double n = frames;
  if (!started_) {
    started_ = true;
    if (random->Chance(rate)) {
      left_ = static_cast<int>(random->Index(frames));
      *began = true;
      return true;
    }
    if (rate < 1.0) return false;
  }
  // In a frame that no earlier burst covers, a burst begins with probability p,
  // so that the share n p / (n p + 1 - p) of frames is the rate.
  const double p = rate / (n * (1.0 - rate) + rate);
  if (!random->Chance(p)) return false;
  left_ = frames - 1;
  *began = true;
  return true;
}

Eigen::Vector2d SlowGaussian::Step(double rho, Random* random) {
  const Eigen::Vector2d fresh = NormalVector(random);
  value_ =
      started_
          ? Eigen::Vector2d(rho * value_ + std::sqrt(1.0 - rho * rho) * fresh)
          : fresh;
  started_ = true;
  return value_;
}

double SlowStudentScale::Step(double rho, double degrees_of_freedom,
                              Random* random) {
  const double shape = 0.5 * degrees_of_freedom;
  if (gamma_ < 0.0 || rho <= 0.0) {
    gamma_ = random->Gamma(shape);
  } else if (rho < 1.0) {
    const double kept = random->Gamma(rho * shape);
    const double lost = random->Gamma((1.0 - rho) * shape);
    const double fresh = random->Gamma((1.0 - rho) * shape);
    gamma_ = gamma_ * kept / (kept + lost) + fresh;
  }
  return std::sqrt((degrees_of_freedom - 2.0) /
                   (2.0 * std::max(gamma_, 1e-12)));
}

}  // namespace kinegraph
