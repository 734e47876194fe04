// Learns the confidence below which a detector's joints count as absent. Some
// detectors report a position for every joint, even the maximum of a heat map
// that is low everywhere. Such a position is not a measurement with a large
// error, so weighting by confidence (solvers/noise/frame_points.h) cannot
// describe it.
#ifndef KINEGRAPH_SOLVERS_SESSION_PRESENCE_H_
#define KINEGRAPH_SOLVERS_SESSION_PRESENCE_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/geometry/epipolar.h"

namespace kinegraph {

// Counts, by confidence, how many joints of a detection are far from the
// epipolar lines of the same joints with high confidence in another view.
// Detections are matched between views by joints with high confidence in both.
class PresenceLearner {
 public:
  // `cameras` must outlive the learner.
  explicit PresenceLearner(const CameraRig& cameras);

  // `frame` has one view per camera.
  void See(const DetectionFrame& frame);

  // The confidence below which joints are absent; 0 if none are, or if there
  // are too few observations.
  double LeastConfidence() const;

 private:
  static constexpr size_t kBinCount = 9;
  struct Bin {
    int64_t seen = 0;
    int64_t astray = 0;  // of these, far from the epipolar line
  };
  // A detection's joints, undistorted.
  struct Ideal {
    std::vector<Keypoint> joints;
    double size_px = 0.0;  // of the box around joints with high confidence
  };

  Ideal IdealOf(const Detection& detection, const Camera& camera) const;
  // Median epipolar distance of the joints with high confidence in both
  // detections; infinite if there are fewer than four.
  double SureDistance(int view_a, const Ideal& a, int view_b,
                      const Ideal& b) const;
  void Compare(int view_a, const Ideal& a, int view_b, const Ideal& b);

  const CameraRig& cameras_;
  const EpipolarGeometry epipolar_;
  std::array<Bin, kBinCount> bins_{};
};

// Marks joints below the confidence as not found.
void DropAbsentJoints(double least_confidence, DetectionFrame* frame);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_PRESENCE_H_
