// Estimates the size and correlation time of a detector's errors in a recording
// from the residuals of joints triangulated frame by frame, independent of
// motion; and a common factor for all sigmas from the residuals of the final
// estimate.
#ifndef KINEGRAPH_SOLVERS_NOISE_PIXEL_NOISE_H_
#define KINEGRAPH_SOLVERS_NOISE_PIXEL_NOISE_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "core/skeleton/skeleton.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/learnt_noise.h"

namespace kinegraph {

// The value below which a chi-square variable with `degrees_of_freedom` > 0
// lies with probability `share`, 0 < share < 1. Relative error below 1e-9.
double ChiSquareQuantile(double share, double degrees_of_freedom);

// The least-squares residuals of one joint in one frame.
struct TriangulationResiduals {
  struct View {
    int view_idx = 0;
    Eigen::Vector2d residual = Eigen::Vector2d::Zero();  // in modelled sigmas
  };
  std::vector<View> views;  // two or more
  // Sum of the squares of the residuals; for Gaussian errors, chi-square with
  // degrees_of_freedom() times the square of the scale.
  double square = 0.0;
  int degrees_of_freedom() const {
    return 2 * static_cast<int>(views.size()) - 3;
  }
};

// Factor of the modelled sigma, by class of joint. The 0.3 quantile of the
// squares is matched to that of chi-square, with 2 n - 3 degrees of freedom for
// n views; outliers hardly affect low quantiles. Classes with few observations
// are shrunk towards the scale of all classes, and this towards 1. Uses bins of
// 2 % of sigma, so memory does not grow and the result is available at any
// time.
class NoiseScales {
 public:
  NoiseScales();

  void Add(JointClass joint_class, const TriangulationResiduals& residuals);

  // Factor on sigma, 1/16 .. 16.
  double Scale(JointClass joint_class) const;
  // Number of joints of this class, summed over frames.
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
  // The low quantile of ln variance.
  static double LowQuantile(const Counts& counts);

  std::array<Counts, kJointClassCount> classes_;
  Counts all_;
};

// Learns the correlation from pairs of residuals of one joint in one view, up
// to a quarter of a second (at least three frames) apart, in frames without
// outliers in which the same number of views saw the joint.
class CorrelationLearner {
 public:
  CorrelationLearner(int joint_count, int view_count, double frame_rate_hz);

  // Adds the next frame of a joint; `scale` is the factor of its modelled
  // sigma. Times of a joint must ascend.
  void Add(int joint_idx, TimeNs time, double scale,
           const TriangulationResiduals& residuals);

  // The estimate under a prior, as if a few pairs with the typical correlation
  // of detectors had been seen.
  ErrorCorrelation Fit() const;

 private:
  // Sums over the pairs of residuals at one lag.
  struct Lag {
    double product = 0.0;
    double square = 0.0;
  };
  struct Past {
    TimeNs time = 0;
    int view_count = 0;
    Eigen::Vector2d residual = Eigen::Vector2d::Zero();
  };

  const int view_count_;
  const double frame_s_;
  // By joint and view: the residuals within the longest lag, newest last.
  std::vector<std::vector<Past>> pasts_;
  std::vector<Lag> lags_;  // for lags of 1, 2, .. frames
};

// Appends to `squares` the squared whitened residuals |r|^2 of a chain's frames
// `begin` .. `end` - 1 at its states. Fitting the state, whose covariance is C,
// reduces the expected |r|^2 from 2 to 2 - trace(J C J'); each square is
// divided by the fraction that remains. Gated measurements and fractions below
// 0.3 are omitted.
void CollectSquares(const JointChain& chain,
                    const std::vector<Matrix6d>& covariances, size_t begin,
                    size_t end, std::vector<double>* squares);

// The factor on all sigmas after which `squares`, the squared norms of whitened
// residuals, are those of standard normal 2-vectors, except for outliers:
// starts with the median, then uses the mean of the values within three sigmas.
// Shrunk towards 1 if there are few values, limited to 1/4 .. 4.
double EstimateNoiseScale(std::vector<double> squares);

// Multiplies all sigmas.
void ScaleSigmas(double scale, PersonProblem* problem);

// Estimates the scale from the frames of a window that become final. Keeps a
// bounded number of the newest residuals.
class CausalNoiseScale {
 public:
  double scale() const { return scale_; }

  // To be called whenever frames become final. True the first time and every
  // fifth time after it; the residuals of these frames must then be passed to
  // Add. They contain nearly all the information, because errors of consecutive
  // frames are correlated.
  bool AwaitTurn();
  // `squares`: from CollectSquares of a problem whose sigmas the caller has
  // multiplied by `applied`; Add removes this factor.
  void Add(const std::vector<double>& squares, double applied);

 private:
  std::vector<double> squares_;  // of unscaled sigmas; a ring when full
  size_t next_ = 0;
  int64_t turns_ = 0;
  double scale_ = 1.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_PIXEL_NOISE_H_
