// Estimates the level of process noise, for each class of joints over the
// recording and for each group of joints by frame, from the likelihoods of
// Kalman filters that differ in their process noise.
#ifndef KINEGRAPH_SOLVERS_NOISE_MOTION_LEVEL_H_
#define KINEGRAPH_SOLVERS_NOISE_MOTION_LEVEL_H_

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/skeleton/skeleton.h"
#include "solvers/noise/frame_points.h"
#include "solvers/noise/learnt_noise.h"

namespace kinegraph {

// Process noise has this many levels: factors of the typical power, the same
// for every class of joint.
inline constexpr int kLevelCount = 10;
// One number per level, e.g. its log-evidence.
using Levels = std::array<double, kLevelCount>;

// Typical power of the white noise on acceleration [m^2/s^3]: medians over
// recorded walking, running, hopping, acrobatics and dance.
double UsualProcessNoise(JointClass joint_class);

// ln of the ratio of level `level` to the typical power; the levels have even
// logarithmic steps from 1/40 to 1000.
double LogLevel(int level);

// Filters of one joint, one per level and axis.
//
// State x = (p, v, n): position, velocity, and the correlated part of the
// point's error in units of its standard deviation. Over a time dt, with white
// noise of power q on the acceleration and an error that decays by phi =
// exp(-dt / tau),
//       [1 dt  0 ]        [q dt^3 / 3  q dt^2 / 2     0     ]
//   F = [0  1  0 ],   Q = [q dt^2 / 2     q dt        0     ]
//       [0  0 phi]        [    0           0      1 - phi^2 ]
// (Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
// Navigation, 2001, sec. 6.2.2; the third row keeps n at unit variance). A
// point of variance R, of which the share a is correlated, is
//   z = p + g n + e,   g = sqrt(a R),   var e = (1 - a) R,
// so with H = (1, 0, g) the innovation z - H x has the variance
//   S = H P H' + (1 - a) R
// (to which Innovate adds 2 % of R and (0.1 mm)^2, so that it is never zero).
// The likelihood of a level is the product of its innovations' densities: each
// frame and axis adds -(ln S + (z - H x)^2 / S) / 2 to the level's log-evidence
// (Schweppe, IEEE Trans. Information Theory 1965).
class FilterBank {
 public:
  // `usual`: as returned by UsualProcessNoise.
  explicit FilterBank(double usual) : usual_(usual) {}

  // Processes the next frame and adds the log-evidence of each level to
  // `evidence`; adds nothing without a point. Robust: innovations with a mean
  // over axes of (z - H x)^2 / S above 3 have a reduced weight, in the
  // likelihood and in the filter.
  void Add(TimeNs time, const std::optional<FramePoint>& point,
           const ErrorCorrelation& correlation, Levels* evidence);

 private:
  // An innovation before the filter's correction.
  struct Innovation {
    double gain;    // g, of the correlated error [m]
    double error;   // z - H x [m]
    double spread;  // its variance S [m^2]
  };

  // The state's mean and covariance.
  struct Axis {
    double p = 0.0, v = 0.0, n = 0.0;
    double pp = 1.0, pv = 0.0, vv = 9.0, pn = 0.0, vn = 0.0, nn = 1.0;

    // `dt` [s]; `phi`: factor by which the correlated error decays; `q`: power
    // of the white noise on acceleration [m^2/s^3].
    void Predict(double dt, double phi, double q);
    Innovation Innovate(double position_m, double variance_m2,
                        double lasting_share) const;
    // `wider`: factor of the innovation's variance.
    void Correct(const Innovation& innovation, double wider);
  };

  // Starts the filters at the point.
  void Start(const FramePoint& point);

  double usual_;
  std::optional<TimeNs> time_;  // of the last frame; none before the first
  std::array<std::array<Axis, 3>, kLevelCount> filters_;
};

// Groups of joints with a common level. Head, trunk, shoulders and hips move
// with the body, so the joints of each of these classes are one group. Limbs do
// not: in walking one leg swings while the other stands, and in throwing one
// arm moves. Their joints of one class on one side of the body are a group.
class MotionGroups {
 public:
  explicit MotionGroups(const Skeleton& skeleton);

  int size() const { return static_cast<int>(classes_.size()); }
  int of_joint(int joint_idx) const { return of_joint_[joint_idx]; }
  JointClass joint_class(int group) const { return classes_[group]; }
  // 1 / number of groups of its class.
  double share_of_class(int group) const;

 private:
  std::vector<int> of_joint_;
  std::vector<JointClass> classes_;  // by group
};

// ln of the level, relative to the typical power, that maximises the evidence
// of all frames times a prior of standard deviation 1 around the typical power.
// Interpolated between levels by a parabola; at least a tenth of the typical
// power.
double RecordingLevel(const Levels& evidence);

// A Markov chain over the levels in continuous time: jumps to neighbouring
// levels with the rates of an Ornstein-Uhlenbeck process around the recording's
// level (standard deviation 1, time constant 0.5 s) and, every five seconds on
// average, to any level.
class LevelChain {
 public:
  using Vector = Eigen::Matrix<double, kLevelCount, 1>;
  using Matrix = Eigen::Matrix<double, kLevelCount, kLevelCount>;

  // `recording_level`: as returned by RecordingLevel.
  explicit LevelChain(double recording_level);

  // The belief before any observation.
  const Vector& stationary() const { return stationary_; }
  // Column i: distribution after `dt` from level i. Valid until the next call.
  // Time steps that differ by at most 2 ns, as by rounding, are treated as
  // equal.
  const Matrix& Transition(TimeNs dt);

 private:
  Matrix Exponential(double dt_s) const;

  Vector stationary_;
  Matrix rates_;                    // column sums are zero
  std::map<TimeNs, Matrix> known_;  // by dt
};

// Likelihood of a frame under each level, relative to the greatest.
LevelChain::Vector Likelihood(const Levels& evidence);

// The normalised product of prediction and likelihood, a step of the
// forward-backward algorithm (Rabiner 1989).
LevelChain::Vector Believe(const LevelChain::Vector& predicted,
                           const LevelChain::Vector& likelihood);

// Mean of ln level in each frame, given the likelihoods of all frames, `seen`
// (forward-backward algorithm). `first`: the belief for the first frame before
// its observation.
std::vector<double> SmoothLevels(const LevelChain::Vector& first,
                                 const std::vector<TimeNs>& times,
                                 const std::vector<LevelChain::Vector>& seen,
                                 LevelChain* chain);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_MOTION_LEVEL_H_
