// A cheap check of a finished run: whether each camera sees people where, and
// when, the other cameras do. Used for warnings at the end of `track`; the
// doctor examines more.
#ifndef KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_
#define KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// A camera with a problem, and a sentence that describes it.
struct CameraWarning {
  enum class Kind {
    kHardlySeen,  // few people are detected where the other views place them
    kElsewhere,   // people are detected at an offset from these places
    kOffBeat,     // images appear to have been captured earlier or later
  };
  Kind kind;
  std::string text;
};

class CameraCheck {
 public:
  // `cameras` in view order; the skeletons of the detections and of the tracks.
  CameraCheck(CameraRig cameras, const Skeleton& detections,
              const Skeleton& tracks);

  // Adds a frame and the tracks written for it; frames must be in ascending
  // order, but their times may stop or step back. Keeps short bursts of frames,
  // spread evenly over the recording; their number is bounded.
  void See(const DetectionFrame& seen, const TrackFrame& tracked);

  struct View {
    // Written poses with their middle inside the view's image, of people whom
    // at least two other views detect (one, if there are two views).
    int64_t people = 0;
    int64_t seen = 0;  // of these, poses with a detection nearby
    // Median of the detections minus the projections of the other views'
    // estimate; with only two views, perpendicular to the epipolar line.
    double x_px = 0.0;
    double y_px = 0.0;
    double px_per_m = 0.0;  // at the people's depth; 0: unknown
    size_t in_motion = 0;   // moving MotionSegments; 0 with two views
    double late_s = 0.0;    // true minus recorded capture times
    double late_sigma_s = 0.0;
    double late_m = 0.0;  // RMS displacement of moving joints in this time
  };
  // `metre`: one metre in the unit of the cameras' lengths (SubjectScale).
  std::vector<View> Views(double metre = 1.0) const;
  // One warning per problem; empty if there are none or too little was seen.
  std::vector<CameraWarning> Warnings(double metre = 1.0) const;

 private:
  struct Kept {
    int64_t burst = 0;
    DetectionFrame seen;
    std::vector<PersonPose> people;
  };

  CameraRig cameras_;
  // By joint of the detections: its index in the tracks, or -1.
  std::vector<int> track_joint_;
  DetectionHeader header_;
  std::optional<TimeNs> last_time_;
  TimeNs elapsed_ = 0;  // since the first frame
  int64_t stride_ = 1;  // one burst in `stride_` is kept
  std::vector<Kept> kept_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_
