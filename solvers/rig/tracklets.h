// 2D tracklets: a person in one view from frame to frame, by the image alone.
#ifndef KINEGRAPH_SOLVERS_RIG_TRACKLETS_H_
#define KINEGRAPH_SOLVERS_RIG_TRACKLETS_H_

#include <Eigen/Core>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"

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

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_TRACKLETS_H_
