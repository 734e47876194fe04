// What a detector's confidence is worth in this recording: by which power of it
// errors shrink. From views that see one joint in one frame, so that motion has
// no part in it.
#ifndef KINEGRAPH_SOLVERS_NOISE_CONFIDENCE_POWER_H_
#define KINEGRAPH_SOLVERS_NOISE_CONFIDENCE_POWER_H_

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/skeleton/skeleton.h"
#include "solvers/filters/robust_triangulation.h"

namespace kinegraph {

// How the modelled sigmas are to be changed.
struct ConfidenceWeighting {
  // Added to the power that the noise model believes in (GraphOptions::
  // confidence_power).
  double added_power = 0.0;
  // ln confidence at which nothing changes: the mean of what was seen, so that
  // the size of the errors is left to NoiseScales.
  double mean_log = 0.0;

  // On the modelled sigma of a measurement with that ln confidence.
  double SigmaFactor(double log_confidence) const {
    return added_power == 0.0
               ? 1.0
               : std::exp(-added_power * (log_confidence - mean_log));
  }
};

// Compares powers by how probable they make the residuals of least squares:
// the restricted likelihood of one triangulated joint (its position integrated
// out), with the tails of a t distribution for outliers, and each power with
// the size of errors that suits it best, by class of joint.
class ConfidenceLearner {
 public:
  // `believed_power` is where it starts; `frame_rate_hz` > 0.
  ConfidenceLearner(double believed_power, double frame_rate_hz);

  // The next frame: false when it follows the last one that was looked at too
  // soon to tell anything new (a detector's errors last), so that its joints
  // need not be added. `time` ascends.
  bool BeginFrame(TimeNs time);

  // A joint of one frame: what its views measured, with the sigmas of
  // `weighting` and the ln of their confidences, around the point where least
  // squares put it.
  void Add(JointClass joint_class, const std::vector<PixelPoint>& views,
           const std::vector<double>& log_confidences,
           const Eigen::Vector3d& point_m,
           const ConfidenceWeighting& weighting);

  // What was learnt so far; the believed power where it tells little.
  ConfidenceWeighting Fit() const;

 private:
  // ln of the factor on all sigmas: 1/16 to 16, as NoiseScales allows.
  static constexpr int kScaleCount = 15;
  using Scales = std::array<double, kScaleCount>;

  bool Linearise(const std::vector<PixelPoint>& views,
                 const std::vector<double>& log_confidences,
                 const Eigen::Vector3d& point_m);
  bool LogLikelihood(double added_power, Scales* log_likelihood) const;

  const double believed_power_;
  const double frame_s_;        // between frames that are looked at, at least
  const double weight_;         // of a frame
  std::optional<TimeNs> last_;  // that was looked at
  std::vector<double> powers_;  // that are compared, ascending
  // ln likelihood by power and class of joint.
  std::vector<std::array<Scales, kJointClassCount>> log_likelihood_;
  double mean_log_ = 0.0;
  int64_t count_ = 0;  // of views in the mean

  // Of the joint that is added.
  struct View {
    Eigen::Matrix3d square;  // J' J, J by the position [sigmas/m]
    Eigen::Vector3d pull;    // J' r
    double residual_square = 0.0;
    double above_mean = 0.0;  // of ln confidence
  };
  std::vector<View> linearised_;
  std::vector<Scales> by_power_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_CONFIDENCE_POWER_H_
