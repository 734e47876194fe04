// Held-out-camera error: how well tracks made without a camera predict what
// that camera saw. It needs no ground truth and cannot be won by smoothing.
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

// One detection of the scored set.
struct HeldOutPerson {
  int64_t frame = 0;
  int view_idx = 0;
  bool paired = false;  // the run has this person
};

// One joint of such a detection.
struct HeldOutJoint {
  size_t person_idx = 0;  // in HeldOutScores::people
  JointClass joint_class = JointClass::kOther;
  double error_px = 0.0;  // capped; the cap itself without a prediction
  bool predicted = false;
  // r' (J Sigma J' + sigma^2 I)^-1 r of the residual r, where the run gives a
  // covariance Sigma and the caller a sigma: 2 on average if both are right.
  std::optional<double> normalised_squared;
};

// Errors of one or several cameras.
struct HeldOutScores {
  std::vector<HeldOutPerson> people;
  std::vector<HeldOutJoint> joints;
};

// The scored set where none is given: every detection that `reference` (tracks
// of all cameras, with their matches) was made from. `cap_px` is for the caller
// to choose: 10 % of the image width.
HeldOutSet MakeHeldOutSet(const TrackSequence& reference, double cap_px);

// Standard deviation of one coordinate of a detected joint [px].
using DetectorSigma =
    std::function<double(JointClass joint_class, double confidence,
                         double depth_m, double focal_px)>;

// What the detector adds to a joint's pixel in that camera [px].
using DetectorBias = std::function<Eigen::Vector2d(
    const PersonPose& person, int joint_idx, const Camera& camera)>;

struct HeldOutRules {
  enum class Pairing {
    kByDistance,  // one-to-one, by mean distance over the twelve body joints
    kById,        // run and reference were made from the same matches
  };
  Pairing pairing = Pairing::kByDistance;
  DetectorSigma sigma_px;  // empty: no normalised residuals
  // Empty: the 3D point alone is scored; else what the detector would say of
  // it. Scores of the two kinds are never mixed.
  DetectorBias bias_px;
};

// Scores `run`, made without the camera of view `view_idx`, on that view's part
// of the set and appends to `scores`. Scored are the joints that detections and
// `reference` both name, with the set's least confidence; so feet that only
// some skeletons have do not change the set. The people of the run are paired
// with those of the reference as `rules` say. A prediction farther away than
// the cap is as good as none. Throws InputError when the set names a frame,
// detection or person that is not there.
void ScoreHeldOutCamera(const HeldOutSet& set,
                        const DetectionSequence& detections, int view_idx,
                        const Camera& camera, const TrackSequence& reference,
                        const TrackSequence& run, HeldOutScores* scores,
                        const HeldOutRules& rules = {});

// The figures that are printed, in this order.
enum class HeldOutFigure { kMedian, kP90, kP97, kMeanTruncated };
inline constexpr int kHeldOutFigureCount = 4;
// Errors count at most this much in kMeanTruncated [px].
inline constexpr double kHeldOutTruncationPx = 30.0;

struct HeldOutSummary {
  double figures_px[kHeldOutFigureCount] = {};  // NaN: nothing scored
  Interval intervals_px[kHeldOutFigureCount];
  Share predicted;  // joints, within the cap
  Share paired;     // detections with a selected joint

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

// Blocks of frames are drawn with all their cameras and people together.
HeldOutSummary SummariseHeldOut(const HeldOutScores& scores,
                                const HeldOutFilter& filter,
                                const BootstrapOptions& options = {});

// Sum and number of min(error, 30 px) of each frame that the scores have,
// ascending: their pooled ratio is kMeanTruncated.
RatioSeries TruncatedErrors(const HeldOutScores& scores,
                            const HeldOutFilter& filter);
// The frames of those units.
std::vector<int64_t> FramesOf(const HeldOutScores& scores);

// The normalised residuals of held-out cameras.
Consistency HeldOutConsistency(const HeldOutScores& scores);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_HELD_OUT_H_
