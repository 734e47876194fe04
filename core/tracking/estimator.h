// The one interface of every strategy that turns associated detections into a
// person's motion: causal Gaussian, window, batch, classical filters.
//
// An estimator belongs to one person. It decides neither association nor track
// life, so the same observations can be replayed through any strategy.
#ifndef KINEGRAPH_CORE_TRACKING_ESTIMATOR_H_
#define KINEGRAPH_CORE_TRACKING_ESTIMATOR_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/base/time.h"
#include "core/data/observation.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// A detection of this frame, in contrast to reused older ones.
struct FreshView {
  int view_idx = 0;
  TimeNs capture_time = 0;
  int detection_idx = 0;                // Detection::index_in_file
  std::vector<Keypoint> joints;         // raw pixels, one per joint of the
                                        // tracks
  std::vector<FilterVerdict> verdicts;  // one per joint
};

// One frame of one person.
struct EstimatorFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  std::vector<FreshView> views;  // may be empty
  // DLT after the joints filter. Any joint may be missing. kObserved joints
  // were triangulated from two or more views of this frame; kInferred joints
  // used older views or were predicted. Valid only if `has_initial`, which is
  // false when the update failed or nothing was matched.
  bool has_initial = false;
  Pose3d initial;
  std::vector<char> triangulated;  // one per joint: by DLT, not predicted
  // Number of inlier views of each joint in this frame, after the joints
  // filter.
  std::vector<int> inlier_views;
};

// A pose that will not change any more.
struct FinalPose {
  int64_t frame = 0;
  TimeNs time = 0;
  PersonPose person;  // without its id; no joints if there is no pose
};

// Data about its views that a final pose keeps (PersonPose::matches).
enum class KeptMatches : uint8_t {
  kNone,
  kDetections,  // which detections were matched
  kWeights,     // also the weight of each of their joints
};

// Constants of a scene, shared by all estimators.
struct SceneModel {
  CameraRig cameras;
  Skeleton skeleton;  // of the tracks
  double frame_rate_hz = 0.0;
  KeptMatches kept_matches = KeptMatches::kNone;
  bool keep_derivatives = false;  // PersonPose::derivatives
};

class Estimator {
 public:
  virtual ~Estimator() = default;

  // Frames in ascending time: every frame of the track's life, the first with
  // an initial pose.
  virtual void Add(const EstimatorFrame& frame) = 0;

  // The newest stored pose, from the last frame whose update succeeded. Empty
  // before the first Add.
  virtual const Pose3d& Last() const = 0;
  virtual TimeNs LastTime() const = 0;
  // The pose expected at `time` >= LastTime(), written to `pose`.
  virtual void Predict(TimeNs time, Pose3d* pose) const = 0;

  // Moves out the poses that became final since the last call, in order; there
  // is one for each Add, possibly some frames later.
  virtual void ExtractFinals(std::vector<FinalPose>* finals) = 0;
  // Makes all remaining poses final. Nothing may be added afterwards.
  virtual void Finish() = 0;
};

// The newest pose of `estimator`, translated to the position expected at
// `time`: by the geometric median of the joints' predicted displacements. If
// `time` is more than `horizon_s` after the pose, the displacement is scaled
// down to `horizon_s`. The swing of the limbs is not predicted.
void ExpectBody(const Estimator& estimator, TimeNs time, double horizon_s,
                Pose3d* pose);

// Copies the views of `frame` to a final pose: inlier views after the joints
// filter and, where matches are kept, the score (mean confidence of the
// measured joints) and each view's detection; if weights are kept, too, weight
// 1 for joints that the filter kept, 0 for those it removed and none for
// unmeasured ones.
void DescribeViews(const EstimatorFrame& frame, KeptMatches kept,
                   PersonPose* person);

using EstimatorFactory =
    std::function<std::unique_ptr<Estimator>(const SceneModel& scene)>;

// Moves all of `from` to the end of `to`: Estimator::ExtractFinals.
void MoveFinals(std::vector<FinalPose>* from, std::vector<FinalPose>* to);

// The pose `last` as a prediction for a person who stays where they are: its
// joints become inferred.
void ExpectUnmoved(const Pose3d& last, Pose3d* pose);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_ESTIMATOR_H_
