// Agreement of tracks with markers on a common clock and in a common world:
// errors by joint and axis of the body, coverage of reported intervals, and the
// measures of published protocols.
#ifndef KINEGRAPH_CORE_EVALUATION_MARKERS_AGREEMENT_H_
#define KINEGRAPH_CORE_EVALUATION_MARKERS_AGREEMENT_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/data/pose.h"
#include "core/evaluation/markers/alignment.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

// Truth and tracks of one person in the frames of the tracks, with the same
// joints in the same order, in the truth's world and on its clock.
struct PairedMotion {
  TrackSequence truth;
  TrackSequence tracks;
  // One per joint: whether markers enclose its centre. Set by the caller of
  // PairMotion.
  std::vector<bool> is_centre;

  // Whether the errors of a joint are pooled: those of centres, or all if there
  // is no centre.
  bool IsPooled(size_t joint) const;
};

// The truth's joints, interpolated between its samples, in each frame of the
// tracks in which the truth has a joint. They are paired with `person` or, in
// frames without that identity and unless `only`, with the nearest person
// within half a metre; frames without a pair are left out. Covariances rotate
// with the tracks.
PairedMotion PairMotion(const TrackSequence& truth, const JointPaths& paths,
                        const TrackSequence& tracks, TrackId person, bool only,
                        const JointPairs& joints, const ClockFit& clock,
                        const WorldFit& world);

// Calibration of reported covariances against actual errors.
class Calibration {
 public:
  // A covariance that is not positive definite counts as an ellipsoid that
  // contains no error.
  void Add(const Eigen::Vector3d& error_m, const Eigen::Matrix3d& covariance);

  int64_t count() const { return count_; }
  // Share of the errors within the ellipsoid of probability `level`, one of
  // 0.05, 0.10, ..., 0.95; NaN without covariances.
  double Covered(double level) const;
  // Mean of |Covered(level) - level| over these levels.
  double ExpectedCalibrationError() const;
  // Sharpness: square root of the mean trace of the positive definite
  // covariances [m].
  double StatedRms() const;
  // Mean of -log density over the positive definite covariances, lengths in
  // millimetres [nat]: less is better.
  double LogScore() const;

 private:
  static constexpr int kLevels = 19;
  int64_t count_ = 0;
  std::array<int64_t, kLevels> within_ = {};
  int64_t definite_ = 0;
  double trace_m2_ = 0.0;
  double log_score_ = 0.0;
};

struct JointAgreement {
  std::string joint;  // "pooled": over all pooled joints
  bool is_pooled = true;
  int64_t count = 0;
  double median_m = 0.0;  // NaN: no values, as for all below
  double mean_m = 0.0;
  double rms_m = 0.0;
  double p95_m = 0.0;
  Interval median_interval;
  // Found minus true, right, forward, up: mean, and 1.96 standard deviations
  // around it (Bland and Altman 1986).
  Eigen::Vector3d bias_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d limits_m = Eigen::Vector3d::Zero();
  // Median after subtracting, from each half of the recording, the median
  // offset of the other half, in the body's frame.
  double after_offset_median_m = 0.0;
  // Root mean square of the error's first and second derivative.
  double velocity_rms_m_s = 0.0;
  double acceleration_rms_m_s2 = 0.0;
  Calibration calibration;
  Calibration after_offset;
};

struct MotionAgreement {
  std::vector<JointAgreement> joints;
  JointAgreement pooled;
  double mean_of_medians_m = 0.0;  // of the joints that are pooled
  Calibration observed, inferred;  // of the joints that are pooled
  // Mean per joint error of all joints after Procrustes alignment (rotation,
  // translation, scale) of each frame (Ionescu et al. 2014, protocol 2 of
  // Human3.6M).
  double pa_mpjpe_m = 0.0;
  // Share of the joints within 150 mm, and the mean of that share over 0, 5,
  // ..., 150 mm (3DPCK and AUC of MPI-INF-3DHP, Mehta et al. 2017), with the
  // mid-hips aligned, in the frames that have them; without alignment if the
  // skeleton has no hips.
  Share pck_150;
  double auc = 0.0;
  bool root_aligned = false;
};

// `up` is the world's up direction; blocks of the bootstrap are `block_s` long.
MotionAgreement CompareMotion(const PairedMotion& motion,
                              const Eigen::Vector3d& up, double block_s);

// A value of a quantity from truth and tracks at one time, with the 95 %
// interval reported for the tracks.
struct PairedValue {
  double truth = 0.0;
  double found = 0.0;
  double low = 0.0;  // NaN: none
  double high = 0.0;
};
struct ValueAgreement {
  int64_t count = 0;
  double bias = 0.0;    // mean of found minus true
  double limits = 0.0;  // 1.96 standard deviations
  double rms = 0.0;
  double after_offset_rms = 0.0;  // other half's median subtracted
  Share covered;                  // by the interval
  Share covered_after_offset;
};
// Values in temporal order. `period` > 0: cyclic, as angles are.
ValueAgreement CompareValues(const std::vector<PairedValue>& values,
                             double period);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MARKERS_AGREEMENT_H_
