// How strongly a joint is driven, by the evidence of Kalman filters that
// assume different answers.
#ifndef KINEGRAPH_SOLVERS_NOISE_FILTER_BANK_H_
#define KINEGRAPH_SOLVERS_NOISE_FILTER_BANK_H_

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/base/time.h"
#include "core/skeleton/skeleton.h"
#include "solvers/noise/frame_points.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

// Levels of process noise, the same factors for every class of joint.
inline constexpr int kLevelCount = 10;
using Levels = std::array<double, kLevelCount>;

// Usual power of the white noise on acceleration [m^2/s^3]: medians over
// recorded walking, running, hopping, acrobatics and dance.
double UsualProcessNoise(JointClass joint_class);

// ln of level `level` over the usual power: even steps from 1/40 to 1000.
double LogLevel(int level);
double LogLevelStep();

// Filters of one joint, one a level and axis.
//
// State x = (p, v, n): position, velocity, and the lasting part of the point's
// error in units of its standard deviation. Over a time dt, with white noise of
// power q on the acceleration and an error that decays by phi = exp(-dt / tau),
//       [1 dt  0 ]        [q dt^3 / 3  q dt^2 / 2     0     ]
//   F = [0  1  0 ],   Q = [q dt^2 / 2     q dt        0     ]
//       [0  0 phi]        [    0           0      1 - phi^2 ]
// (Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
// Navigation, 2001, sec. 6.2.2; the third row keeps n at unit variance). A
// point of variance R of which the share a lasts is
//   z = p + g n + e,   g = sqrt(a R),   var e = (1 - a) R,
// so that with H = (1, 0, g) the innovation z - H x has the variance
//   S = H P H' + (1 - a) R.
// The likelihood of a level is the product of its innovations' densities: each
// frame and axis adds -(ln S + (z - H x)^2 / S) / 2 to the level's log-evidence
// (Schweppe, IEEE Trans. Information Theory 1965).
class FilterBank {
 public:
  // `usual` as UsualProcessNoise gives it.
  explicit FilterBank(double usual) : usual_(usual) {}

  // The next frame: adds the log-evidence of each level to `evidence`. Nothing
  // is added without a point. A robust likelihood: an innovation farther out
  // than 3 (mean over axes of e^2 / S) counts less, and moves the filter less.
  void Add(TimeNs time, const std::optional<FramePoint>& point,
           const ErrorCorrelation& correlation, Levels* evidence);

 private:
  struct Axis {
    double p = 0.0, v = 0.0, n = 0.0;
    double pp = 1.0, pv = 0.0, vv = 9.0, pn = 0.0, vn = 0.0, nn = 1.0;
  };
  struct Filter {
    std::array<Axis, 3> axes;
  };

  // Innovations of the three axes, before the filter takes them in.
  struct Innovation {
    std::array<double, 3> gain{};    // of the lasting error [m]
    std::array<double, 3> error{};   // [m]
    std::array<double, 3> spread{};  // its variance [m^2]
    double mean_square = 0.0;        // mean over axes of error^2 / spread
    double log_spread = 0.0;         // sum over axes
  };

  // `phi`: what is left of the lasting error; `power`: of the white noise on
  // acceleration [m^2/s^3].
  static void Predict(double dt_s, double phi, double power, Filter* filter);
  static Innovation Innovate(const Filter& filter, const FramePoint& point,
                             const ErrorCorrelation& correlation);
  // `wider`: factor on the innovation's variance.
  static void Correct(const Innovation& innovation, double wider,
                      Filter* filter);

  double usual_;
  bool started_ = false;
  TimeNs time_ = 0;
  std::array<Filter, kLevelCount> filters_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_FILTER_BANK_H_
