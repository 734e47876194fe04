// How far the smoother lags behind the motion, and how far off the points are,
// by the points that it smooths.
// Its prior, white acceleration, moves joints at any frequency; people hardly
// do above some Hertz, and then the lag that covariances reckon with is not
// there.
#ifndef KINEGRAPH_SOLVERS_NOISE_MOTION_LAG_H_
#define KINEGRAPH_SOLVERS_NOISE_MOTION_LAG_H_

#include <Eigen/Core>
#include <vector>

#include "solvers/noise/information.h"

namespace kinegraph {

// One joint in one frame.
struct LagSample {
  double time_s = 0.0;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  // NaN: none
  double variance_m2 = 0.0;                           // of an axis of the point
  double process_noise = 0.0;  // since the sample before [m^2/s^3]
  Leftover expected;           // of this variance and process noise
};

// What the smoother leaves of its points, smoothed once more, is lag and little
// noise, since below its crossover the smoother has followed the noise.
class LagLearner {
 public:
  // All samples of a joint, in the order of time.
  void Add(const std::vector<LagSample>& samples);

  // Variances of the points' errors and of the lag over what is expected of
  // them; 1 where little was seen.
  struct Ratios {
    double noise = 1.0;
    double lag = 1.0;
  };
  Ratios Fit() const;

 private:
  double count_ = 0.0;  // of independent values
  // What was left at first over the noise that is expected of it, by sample.
  std::vector<float> first_;
  // Sums over independent values: what was left then over its lag, and what is
  // expected of the other in both.
  double first_lag_ = 0.0;
  double left_ = 0.0, left_noise_ = 0.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_MOTION_LAG_H_
