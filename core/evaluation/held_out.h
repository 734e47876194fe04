// Held-out-camera error: the error with which tracks made without a camera
// predict that camera's detections. It needs no ground truth, and smoothing
// cannot improve it artificially.
#ifndef KINEGRAPH_CORE_EVALUATION_HELD_OUT_H_
#define KINEGRAPH_CORE_EVALUATION_HELD_OUT_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/data/detection.h"
#include "core/data/held_out.h"
#include "core/data/pose.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/statistics.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// One detection of the scored set: one person in one image.
struct HeldOutPerson {
  int64_t frame = 0;
  int view_idx = 0;
  bool paired = false;  // the run has this person
};

// One scored joint of a detection.
struct HeldOutJoint {
  size_t person_idx = 0;  // in HeldOutScores::people
  JointClass joint_class = JointClass::kOther;
  double error_px = 0.0;  // capped; equals the cap without a prediction
  bool predicted = false;
  // r' (J Sigma J' + sigma^2 I)^-1 r of the residual r (without bias_px), where
  // the run has a covariance Sigma and the caller gives a sigma: 2 on average
  // if both are correct.
  std::optional<double> normalised_squared;
};

// Errors of one or several cameras.
struct HeldOutScores {
  std::vector<HeldOutPerson> people;
  std::vector<HeldOutJoint> joints;
};

// The default scored set: every detection from which `reference` (tracks of all
// cameras, with their matches) was made. `cap_px` is stored in the set; callers
// that derive it from a camera's image width set it anew for each camera.
HeldOutSet MakeHeldOutSet(const TrackSequence& reference, double cap_px);

// Standard deviation of one coordinate of a detected joint [px].
using DetectorSigma =
    std::function<double(JointClass joint_class, double confidence,
                         double depth_m, double focal_px)>;

// The detector's bias of a joint's pixel in that camera [px].
using DetectorBias = std::function<Eigen::Vector2d(
    const PersonPose& person, int joint_idx, const Camera& camera)>;

struct HeldOutRules {
  enum class Pairing {
    kByDistance,  // one-to-one, by mean distance over CommonBodyJoints
    kById,        // run and reference were made from the same matches
  };
  Pairing pairing = Pairing::kByDistance;
  DetectorSigma sigma_px;  // empty: no normalised residuals
  // Empty: detections are compared with the projection of the 3D point. Else
  // the bias is added to the projection. Scores of the two kinds must not be
  // mixed.
  DetectorBias bias_px;
};

// Scores `run`, made without the camera of view `view_idx`, on that view's part
// of the set and appends to `scores`. The scored joints are those that both the
// detections and `reference` have, with at least the set's minimum confidence,
// so feet that only some skeletons have do not change the set. The people of
// the run are paired with those of the reference by `rules`. A prediction
// farther away than the cap counts as none, except in normalised_squared.
// Throws InputError when the set refers to a frame, detection or person that
// does not exist, or when the rates of run and reference differ so that frames
// of the reference lie between those of the run.
void ScoreHeldOutCamera(const HeldOutSet& set,
                        const DetectionSequence& detections, int view_idx,
                        const Camera& camera, const TrackSequence& reference,
                        const TrackSequence& run, HeldOutScores* scores,
                        const HeldOutRules& rules = {});

// The reported statistics, in this order.
enum class HeldOutFigure { kMedian, kP90, kP97, kMeanTruncated };
inline constexpr int kHeldOutFigureCount = 4;
// Upper limit of a single error in kMeanTruncated [px].
inline constexpr double kHeldOutTruncationPx = 30.0;

struct HeldOutSummary {
  double figures_px[kHeldOutFigureCount] = {};  // NaN: nothing scored
  Interval intervals_px[kHeldOutFigureCount];
  Share predicted;  // selected joints with an error below the cap
  // Detections whose person the run has, of those with a selected joint.
  Share paired;

  double figure_px(HeldOutFigure figure) const {
    return figures_px[static_cast<int>(figure)];
  }
};

using HeldOutFilter =
    std::function<bool(const HeldOutPerson&, const HeldOutJoint&)>;
HeldOutFilter AllJoints();
HeldOutFilter JointsOfClass(JointClass joint_class);
HeldOutFilter JointsOfView(int view_idx);
HeldOutFilter JointsWithoutFace();

// The bootstrap draws blocks of frames with all their cameras and people.
HeldOutSummary SummariseHeldOut(const HeldOutScores& scores,
                                const HeldOutFilter& filter,
                                const BootstrapOptions& options = {});

// For each frame in the scores, ascending, the sum of min(error, 30 px) over
// the selected joints, and their number: the PooledRatio is kMeanTruncated.
RatioSeries TruncatedErrors(const HeldOutScores& scores,
                            const HeldOutFilter& filter);
// The frames of the units of TruncatedErrors.
std::vector<int64_t> FramesOf(const HeldOutScores& scores);

// Consistency of the normalised residuals in held-out cameras.
Consistency HeldOutConsistency(const HeldOutScores& scores);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_HELD_OUT_H_
