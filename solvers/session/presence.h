// Below which confidence a detector's joints are not there at all. Some write a
// position for every joint, the highest place of a map that is low everywhere;
// that is no measurement with a large error, and no power of the confidence
// (solvers/noise/frame_points.h) describes it.
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

// Counts, by confidence, how many joints of a detection lie far from the
// epipolar lines of the same joints that another view is sure of. Which two
// detections are one person their sure joints tell.
class PresenceLearner {
 public:
  // `cameras` must outlive it.
  explicit PresenceLearner(const CameraRig& cameras);

  void See(const DetectionFrame& frame);

  // Joints with less confidence are not there; 0: all are, or too little was
  // seen.
  double LeastConfidence() const;

 private:
  static constexpr size_t kBinCount = 9;
  struct Bin {
    int64_t seen = 0;
    int64_t astray = 0;  // of them
  };
  // A detection's joints, freed of the lens.
  struct Ideal {
    std::vector<Keypoint> joints;
    double size_px = 0.0;  // of the box around those that are sure
  };

  Ideal IdealOf(const Detection& detection, const Camera& camera) const;
  // Of the joints that both are sure of, in the median; infinite with fewer
  // than four.
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
