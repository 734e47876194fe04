// A cheap look at a finished run: does each camera see people where, and when,
// the others do? For warnings at the end of `track`; the doctor says more.
#ifndef KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_
#define KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// One camera that is off, in a sentence that names it.
struct CameraWarning {
  enum class Kind {
    kHardlySeen,  // people are hardly found where the others put them
    kElsewhere,   // people are seen beside where the others put them
    kOffBeat,     // they are seen as if pictures were taken earlier or later
  };
  Kind kind;
  std::string text;
};

class CameraCheck {
 public:
  // Cameras in the order of the views; skeletons of detections and tracks.
  CameraCheck(CameraRig cameras, const Skeleton& detections,
              const Skeleton& tracks);

  // A frame and what was written of it, ascending. Keeps bursts of them, evenly
  // over the recording, as many for any length.
  void See(const DetectionFrame& seen, const TrackFrame& tracked);

  struct View {
    int64_t people = 0;  // written people whose place the view shows
    int64_t seen = 0;    // of them, with a detection near by
    // Of detection less the projection of what the other views say; of two
    // views alone, across the epipolar line of the other. Medians.
    double x_px = 0.0;
    double y_px = 0.0;
    double px_per_m = 0.0;  // at the people's depth; 0: nothing is known
    size_t in_motion = 0;   // stretches of joints
    double late_s = 0.0;    // beyond what the times tell
    double late_sigma_s = 0.0;
    double late_m = 0.0;  // what that is where joints move
  };
  // With lengths in a metre that is so long (SubjectScale).
  std::vector<View> Views(double metre = 1.0) const;
  // Of each camera that is off; empty when all is well or too little was seen.
  std::vector<CameraWarning> Warnings(double metre = 1.0) const;

 private:
  struct Kept {
    int64_t burst = 0;
    DetectionFrame seen;
    std::vector<PersonPose> people;
  };

  CameraRig cameras_;
  std::vector<int> track_joint_;  // of a detection's joint, or -1
  DetectionHeader header_;
  int64_t stride_ = 1;  // of the bursts, every so many are kept
  std::vector<Kept> kept_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_
