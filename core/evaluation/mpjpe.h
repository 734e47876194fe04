// Mean per joint position error (MPJPE), raw and with differences of definition
// removed.
//
// A detector's joints and an annotation's differ by definition, by up to a few
// centimetres (most at the hips). That difference is modelled as one constant
// offset per joint in the body's own frame (right, forward, up), the same for
// all people; the remainder is error.
#ifndef KINEGRAPH_CORE_EVALUATION_MPJPE_H_
#define KINEGRAPH_CORE_EVALUATION_MPJPE_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

struct MpjpeOptions {
  std::vector<FrameRange> frames;                 // of the tracks; empty: all
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  // in the world
};

// The errors of one joint: means over its `count` comparisons, NaN if there are
// none.
struct JointError {
  std::string joint;
  int64_t count = 0;
  double raw_m = 0.0;
  // Median of found minus true along each axis of the body frame (right,
  // forward, up), over the people who have one; 0 if there are none.
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  double bias_removed_m = 0.0;
};

// The errors of one true person in one frame, summed over their joints [m].
struct PersonError {
  int64_t frame = 0;
  int64_t actor = 0;    // the true person's id
  int joint_count = 0;  // compared; 0: person not found
  double raw_m = 0.0;
  double bias_removed_m = 0.0;
};

struct MpjpeResult {
  double raw_m = 0.0;           // mean over all compared joints; NaN: none
  double bias_removed_m = 0.0;  // the same after removal of the offsets
  // PA-MPJPE: after Procrustes alignment of each pose with the true one
  // (rotation, translation, scale); NaN without people of three joints or more.
  double aligned_m = 0.0;
  // PCK: share of true joints whose found counterparts are within 50, 100, 150
  // mm; joints not found count as farther.
  std::vector<double> pck_m = {0.05, 0.1, 0.15};
  std::vector<Share> pck;
  Interval raw_interval;  // blocks drawn within each actor
  Interval bias_removed_interval;
  std::vector<JointError> joints;   // common to both, in the truth's order
  std::vector<PersonError> people;  // by actor, then by frame
  Share found;                      // true person-frames with a counterpart
  // Joints of the true people who were found: share that the found pose has.
  Share joints_found;
};

// The body frame in world axes: columns right, forward, up. nullopt when the
// pose has neither both shoulders nor both hips, or lies on its side.
std::optional<Eigen::Matrix3d> BodyFrame(const Pose3d& pose,
                                         const Skeleton& skeleton,
                                         const Eigen::Vector3d& up);

// Sum [m] and number of the distances between found and true joints after
// Procrustes alignment of the pose (rotation, translation, scale; Umeyama
// 1991), over the joints that both poses have. Zeros for fewer than three
// joints, which always fit.
RatioUnit AlignedError(const Pose3d& truth, const Pose3d& found,
                       const JointPairs& joints);

// Joints are compared by name, people one-to-one within kPersonGateM. The
// errors of a true person without a body frame are not used for the offsets;
// none is subtracted from them.
MpjpeResult EvaluateMpjpe(const TrackSequence& truth,
                          const TrackSequence& tracks,
                          const MpjpeOptions& options = {},
                          const BootstrapOptions& bootstrap = {});

// ---- Reported covariances against actual errors

struct Consistency {
  // Errors within the 95 % ellipsoid. A covariance that is not positive
  // definite contains none.
  Share covered;
  // Normalised estimation error squared, mean per degree of freedom over the
  // positive definite covariances: 1 for correct ones, larger for too small
  // ones (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking
  // and Navigation, section 5.4). NaN: there are none.
  double nees_per_dof = 0.0;
};

// Consistency of the joints of one status.
struct ConsistencyRow {
  JointStatus status = JointStatus::kObserved;
  // Errors of joints with a position, with or without covariance.
  int64_t count = 0;
  double rmse_m = 0.0;  // NaN: none
  Consistency stated;   // of the joints with a covariance
  // Square root of the mean trace of the positive definite covariances; NaN:
  // there are none.
  double stated_rms_m = 0.0;
};

struct ConsistencyResult {
  ConsistencyRow observed;
  ConsistencyRow inferred;
  Consistency all;  // both together
};

// Joints are compared by name, people paired as in EvaluateMpjpe. `frames`:
// numbers of the tracks' frames; empty: all.
ConsistencyResult EvaluateConsistency(
    const TrackSequence& truth, const TrackSequence& tracks,
    const std::vector<FrameRange>& frames = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MPJPE_H_
