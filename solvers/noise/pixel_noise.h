// What a recording tells of the detector's noise and of the motion; and how far
// off the detector is, and for how long: from residuals of joints that were
// triangulated frame by frame, so that motion has no part in it.
#ifndef KINEGRAPH_SOLVERS_NOISE_PIXEL_NOISE_H_
#define KINEGRAPH_SOLVERS_NOISE_PIXEL_NOISE_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Correlation of a detector's errors over time: share * exp(-|dt| / time_s)
// for dt > 0; the rest of the variance is white.
struct ErrorCorrelation {
  double share = 0.0;  // 0 .. 1
  double time_s = 0.1;
};

// What was learnt, in physical units.
struct LearntNoise {
  struct OfClass {
    // Joints of single frames whose residuals told the detector's error; 0:
    // nothing was learnt of this class.
    int64_t joints_seen = 0;
    // Error of a confidence of 1 at 4 m with a focal length of 1000 px [px].
    double sigma_px = 0.0;
    // Power of the white noise on acceleration [m^2/s^3]: the recording's
    // level.
    double process_noise = 0.0;
    // Least and greatest power of any interval of time so far.
    double least_process_noise = 0.0;
    double greatest_process_noise = 0.0;
  };
  std::array<OfClass, kJointClassCount> classes;
  ErrorCorrelation correlation;
  // The errors grow with confidence^-power.
  double confidence_power = 0.0;
};

// One line for the log: "errors last 0.10 s (share 0.90), grow with
// confidence^-0.5; wrist 3.1 px, 4.2
// (0.4 .. 120) m^2/s^3; ...".
std::string ToString(const LearntNoise& learnt);

// {"error_time_s", "error_share", "confidence_power", "classes": {"wrist":
// {"joints_seen", "sigma_px", "process_noise", "least_process_noise",
// "greatest_process_noise"}, ...}}: classes of which something was seen, units
// as in LearntNoise.
std::string ToJson(const LearntNoise& learnt);

// The value below which a chi-square variable with `degrees_of_freedom` > 0
// lies with probability `share`, 0 < share < 1. Relative error below 1e-9.
double ChiSquareQuantile(double share, double degrees_of_freedom);

// What least squares leave of one joint in one frame.
struct TriangulationResiduals {
  struct View {
    int view_idx = 0;
    Eigen::Vector2d residual = Eigen::Vector2d::Zero();  // modelled sigmas
  };
  std::vector<View> views;  // two or more
  // Sum of their squares: chi-square with as many degrees of freedom times the
  // square of the scale, if all is Gaussian.
  double square = 0.0;
  int degrees_of_freedom() const {
    return 2 * static_cast<int>(views.size()) - 3;
  }
};

// Factor on the modelled sigma, by class of joint. A low quantile of the
// squares tolerates outliers, which only make large ones larger: of n views
// with 2 n - 3 degrees of freedom the 0.3 quantile is matched. Classes of which
// little was seen are drawn to the person's own scale, and that to 1. Counts in
// bins of 2 %, so memory does not grow and what came first may be told any
// time.
class NoiseScales {
 public:
  NoiseScales();

  void Add(JointClass joint_class, const TriangulationResiduals& residuals);

  // Factor on sigma, 1/16 .. 16.
  double Scale(JointClass joint_class) const;
  // Joints of that class and frame that were counted.
  int64_t count(JointClass joint_class) const;

 private:
  static constexpr double kBin = 0.04;     // of ln variance
  static constexpr double kLeast = -14.0;  // ln variance
  static constexpr int kBinCount = 700;    // up to e^14
  struct Counts {
    std::vector<float> weight;  // by bin: degrees of freedom
    double total = 0.0;
    int64_t joints = 0;
  };
  static double LowQuantile(const Counts& counts);

  std::array<Counts, kJointClassCount> classes_;
  Counts all_;
};

// Learns it from pairs of residuals of one joint in one view, up to a quarter
// of a second apart, of frames in which as many views saw the joint and none is
// far off.
class CorrelationLearner {
 public:
  CorrelationLearner(int joint_count, int view_count, double frame_rate_hz);

  // The next frame of a joint; `scale` is what its sigma must be multiplied
  // by. Time has advanced since the joint's last frame.
  void Add(int joint_idx, TimeNs time, double scale,
           const TriangulationResiduals& residuals);

  // As if a few pairs with the usual correlation of detectors had been seen
  // before.
  ErrorCorrelation Fit() const;

  // By lag in frames from 1 on: correlation and number of pairs.
  struct Lag {
    double product = 0.0;
    double square = 0.0;
  };
  const std::vector<Lag>& lags() const { return lags_; }

 private:
  // Of one joint in one view: the last quarter of a second, newest last.
  struct Past {
    struct Entry {
      TimeNs time = 0;
      int view_count = 0;
      Eigen::Vector2d residual = Eigen::Vector2d::Zero();
    };
    std::vector<Entry> entries;
    size_t begin = 0;
  };

  const int view_count_;
  const double frame_s_;
  std::vector<Past> pasts_;
  std::vector<Lag> lags_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_PIXEL_NOISE_H_
