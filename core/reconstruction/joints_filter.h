// The joints filter: which views of one joint cannot be right (paper Eq. 2-3).
#ifndef KINEGRAPH_CORE_RECONSTRUCTION_JOINTS_FILTER_H_
#define KINEGRAPH_CORE_RECONSTRUCTION_JOINTS_FILTER_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/span.h"
#include "core/geometry/camera.h"
#include "core/geometry/epipolar.h"
#include "core/reconstruction/options.h"

namespace kinegraph {

// One view's measurement of the joint.
struct JointRay {
  int view_idx = 0;
  Eigen::Vector2d ideal_px = Eigen::Vector2d::Zero();
};

// Decides for one joint. Two views are in conflict when
// E = 1 - distance / alpha < 0 with the mean epipolar distance (Eq. 2). Of two
// conflicting views
// - with a predicted point, the one whose ray is farther from it goes (Eq. 3;
//   on a tie the second),
// - without, the one with the smaller row sum of E over all views goes (on a
//   tie the first; the sums are not recomputed).
// A pair is passed over when either view is already gone, so at least one view
// always stays. Keeps its memory between calls.
class JointsFilter {
 public:
  JointsFilter(const CameraRig& cameras, const EpipolarGeometry& epipolar)
      : cameras_(&cameras), epipolar_(&epipolar) {}

  // (*kept)[i] tells whether rays[i] stays. `predicted_m` may be null.
  void Apply(Span<JointRay> rays, double alpha_px, ConflictOrder order,
             const Eigen::Vector3d* predicted_m, std::vector<char>* kept);

 private:
  // Which of the conflicting i < j goes.
  size_t Loser(Span<JointRay> rays, size_t i, size_t j,
               const Eigen::Vector3d* predicted_m) const;

  const CameraRig* cameras_;
  const EpipolarGeometry* epipolar_;
  std::vector<double> affinity_;  // E, row-major
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_RECONSTRUCTION_JOINTS_FILTER_H_
