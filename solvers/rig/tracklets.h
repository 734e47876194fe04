// 2D tracklets: a person in one view from frame to frame, by the image alone,
// and their motion, by which views find each other's moments.
#ifndef KINEGRAPH_SOLVERS_RIG_TRACKLETS_H_
#define KINEGRAPH_SOLVERS_RIG_TRACKLETS_H_

#include <Eigen/Core>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Joints in normalised image coordinates (x / z, y / z of the camera's frame,
// the lens taken out), a column each; NaN where a joint was not found.
using NormalisedJoints = Eigen::Matrix<double, 2, Eigen::Dynamic>;

struct ViewTracklet {
  int view = 0;
  int first = 0;  // index of its first frame in the recording
  // One a frame from `first` on: the detection's place in its view; -1 where
  // there is none.
  std::vector<int> detections;
  std::vector<NormalisedJoints> joints;  // empty where there is none
  // Usual diagonal of the box around the joints, in normalised coordinates.
  double size = 0.0;

  int end() const { return first + static_cast<int>(detections.size()); }
  bool SeenAt(int frame) const {
    return frame >= first && frame < end() && detections[frame - first] >= 0;
  }
  const NormalisedJoints& At(int frame) const { return joints[frame - first]; }
};

// Whether they have any frame in common.
inline bool Overlap(const ViewTracklet& x, const ViewTracklet& y) {
  return x.first < y.end() && y.first < x.end();
}

// The joints that speak of cameras: shoulders to wrists and hips to ankles of
// people (heads are found in other places from other sides), all joints of
// other skeletons.
std::vector<int> RigJoints(const Skeleton& skeleton);

// Tracklets of at least a second and ten detections, view by view. A
// detection goes on with the tracklet that it is clearly nearest to; where two
// come near, both tracklets end. `cameras`: intrinsics, one a view.
std::vector<ViewTracklet> FollowInViews(const CameraRig& cameras,
                                        const DetectionSequence& detections,
                                        const std::vector<int>& joints);

// Motion of the tracklets that looks alike from every side: heights of joints
// above the body's middle, and their speeds, without what lasts.
class MotionSignals {
 public:
  MotionSignals(const std::vector<ViewTracklet>& tracklets,
                const std::vector<int>& joints, const Skeleton& skeleton,
                int view_count, double frame_rate_hz);

  // Frames between samples.
  int step() const { return step_; }
  // Correlation of two tracklets, sample k of `a` with k + lag of `b`, and how
  // many samples both have; 0 for less than a second.
  struct Likeness {
    double correlation = 0.0;
    int samples = 0;
  };
  Likeness Compare(size_t a, size_t b, int lag) const;

 private:
  struct Signal {
    int first = 0;  // sample
    Eigen::MatrixXf values;
    std::vector<double> energy;  // up to each sample
  };

  int step_ = 1;
  int least_samples_ = 1;
  std::vector<Signal> signals_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_TRACKLETS_H_
