// 2D tracklets: one person followed from frame to frame in one view, and motion
// signals of tracklets that are comparable between views.
#ifndef KINEGRAPH_SOLVERS_RIG_TRACKLETS_H_
#define KINEGRAPH_SOLVERS_RIG_TRACKLETS_H_

#include <Eigen/Core>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Joints in normalised image coordinates (x / z, y / z in the camera's frame,
// lens distortion removed), one per column; NaN if a joint was not found, its
// confidence is below kMinJointConfidence, or its pixel cannot be undistorted.
using NormalisedJoints = Eigen::Matrix<double, 2, Eigen::Dynamic>;

struct ViewTracklet {
  int view = 0;
  int first = 0;  // index of its first frame in the recording
  // By frame from `first` on: index of the detection in its view, or -1.
  std::vector<int> detections;
  std::vector<NormalisedJoints> joints;  // by frame; empty if not detected
  // Median diagonal of the joints' bounding box, in normalised coordinates.
  double size = 0.0;

  int end() const { return first + static_cast<int>(detections.size()); }
  bool SeenAt(int frame) const {
    return frame >= first && frame < end() && detections[frame - first] >= 0;
  }
  const NormalisedJoints& At(int frame) const { return joints[frame - first]; }
};

// Whether the tracklets overlap in time.
inline bool Overlap(const ViewTracklet& x, const ViewTracklet& y) {
  return x.first < y.end() && y.first < x.end();
}

// The joints used to estimate cameras: shoulders to wrists and hips to ankles
// of people (detectors place head joints differently from different sides); the
// association joints of other skeletons.
std::vector<int> RigJoints(const Skeleton& skeleton);

// Tracklets of at least one second and ten detections, view by view. A
// detection continues a tracklet within reach if each is clearly nearest to the
// other; else it begins one. A tracklet within reach of a detection ends if no
// detection continues it. `cameras`: intrinsics, one per view.
std::vector<ViewTracklet> FollowInViews(const CameraRig& cameras,
                                        const DetectionSequence& detections,
                                        const std::vector<int>& joints);

// Motion signals that are similar in views from all directions: heights of
// joints above the body's centre, and speeds of joints relative to it in the
// image, both high-pass filtered.
class MotionSignals {
 public:
  MotionSignals(const std::vector<ViewTracklet>& tracklets,
                const std::vector<int>& joints, const Skeleton& skeleton,
                int view_count, double frame_rate_hz);

  // Frames per sample.
  int step() const { return step_; }
  // Correlation of two tracklets, sample k of `a` with sample k + lag of `b`,
  // and the number of common samples; both 0 for less than one second or fewer
  // than eight samples.
  struct Likeness {
    double correlation = 0.0;
    int samples = 0;
  };
  Likeness Compare(size_t a, size_t b, int lag) const;

 private:
  struct Signal {
    int first = 0;  // index of its first sample
    Eigen::MatrixXf values;
    std::vector<double> energy;  // cumulative, up to each sample
  };

  int step_ = 1;
  int least_samples_ = 1;
  std::vector<Signal> signals_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_TRACKLETS_H_
