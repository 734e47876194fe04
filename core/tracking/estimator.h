// The one interface of every strategy that turns associated detections into a
// person's motion: causal Gaussian, window, batch, classical filters.
//
// An estimator belongs to one person. Association and track life are not its
// business, so the same observations can be replayed through any strategy.
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

// A detection matched in this very frame (never a re-used older one).
struct FreshView {
  int view_idx = 0;
  TimeNs capture_time = 0;
  int detection_idx = 0;                // index_in_file
  std::vector<Keypoint> joints;         // raw pixels, one a joint of the tracks
  std::vector<FilterVerdict> verdicts;  // one a joint
};

// One frame of one person.
struct EstimatorFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  std::vector<FreshView> views;  // may be empty
  // DLT after the joints filter. Any joint may be missing. kObserved joints
  // were triangulated with two or more views of this frame, kInferred ones with
  // older views, or predicted. Valid only if `has_initial`; without it the
  // update failed, or nothing was matched.
  bool has_initial = false;
  Pose3d initial;
  std::vector<char> triangulated;  // one a joint: by DLT, not predicted
  // Inlier views of each joint in this frame, by the joints filter.
  std::vector<int> inlier_views;
};

// A pose that will not change any more.
struct FinalPose {
  int64_t frame = 0;
  TimeNs time = 0;
  PersonPose person;  // without its id; joints empty when there is no pose
};

// What final poses say of the views that saw them (PersonPose::matches).
enum class KeptMatches : uint8_t {
  kNone,
  kDetections,  // which detections
  kWeights,     // and how much each of their joints counted
};

// Constants that every estimator of a scene shares.
struct SceneModel {
  CameraRig cameras;
  Skeleton skeleton;  // of the tracks
  double frame_rate_hz = 0.0;
  KeptMatches kept_matches = KeptMatches::kNone;
};

class Estimator {
 public:
  virtual ~Estimator() = default;

  // Frames come in ascending time, every frame of the track's life, the first
  // with an initial pose.
  virtual void Add(const EstimatorFrame& frame) = 0;

  // The newest stored pose: of the last frame whose update succeeded. Empty
  // before the first Add.
  virtual const Pose3d& Last() const = 0;
  virtual TimeNs LastTime() const = 0;
  // The pose expected at `time` >= LastTime(), written to `pose`.
  virtual void Predict(TimeNs time, Pose3d* pose) const = 0;

  // Moves out the poses that became final since the last call: one for each
  // Add, in order, possibly frames later.
  virtual void ExtractFinals(std::vector<FinalPose>* finals) = 0;
  // Makes all that is left final. Nothing may be added afterwards.
  virtual void Finish() = 0;
};

// The newest pose of `estimator`, moved to where its body is expected at
// `time`: by the way of the joint that goes most like the others, and no
// farther than in `horizon_s`. How limbs swing is not expected.
void ExpectBody(const Estimator& estimator, TimeNs time, double horizon_s,
                Pose3d* pose);

// What `frame` says of its views, for a final pose: inlier views by the joints
// filter; where matches are kept the score, and each view's detection, with
// weight 1 for joints that the filter kept and 0 for those it removed.
void DescribeViews(const EstimatorFrame& frame, KeptMatches kept,
                   PersonPose* person);

using EstimatorFactory =
    std::function<std::unique_ptr<Estimator>(const SceneModel& scene)>;

// Moves all of `from` to the end of `to`: Estimator::ExtractFinals.
void MoveFinals(std::vector<FinalPose>* from, std::vector<FinalPose>* to);

// The pose `last` as what is expected later of somebody who stays: its joints
// are inferred.
void ExpectUnmoved(const Pose3d& last, Pose3d* pose);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_ESTIMATOR_H_
