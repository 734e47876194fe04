// A person's 3D pose from the 2D poses that were matched to them.
#ifndef KINEGRAPH_CORE_RECONSTRUCTION_RECONSTRUCTION_H_
#define KINEGRAPH_CORE_RECONSTRUCTION_RECONSTRUCTION_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/span.h"
#include "core/data/observation.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/geometry/dlt_lanes.h"
#include "core/geometry/epipolar.h"
#include "core/geometry/triangulation.h"
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

// A 2D pose that takes part in a reconstruction.
struct UsedView {
  const Observation* observation = nullptr;
  double age_frames = 0.0;  // 0: seen in this frame
  bool fresh() const { return age_frames == 0.0; }
};

struct Reconstruction {
  // kObserved: triangulated with two or more views of this frame. kInferred:
  // triangulated with older views, or the prediction. kMissing: neither.
  Pose3d pose;
  std::vector<char> triangulated;       // one a joint
  std::vector<int> fresh_inlier_views;  // one a joint
  std::vector<FilterVerdict> verdicts;  // [view * joints + joint]
  // Of the joints that count: measured in at least one view of this frame, of
  // these left without a triangulation, and of those measured by one view
  // alone.
  int seen_joints = 0;
  int lost_joints = 0;
  int alone_joints = 0;
};

// Joints filter, then weighted DLT, joint by joint. Keeps its memory between
// calls; not for two threads at once.
class Reconstructor {
 public:
  // `cameras` and `epipolar` must outlive the object. `skeleton` is that of the
  // observations; its association joints count.
  Reconstructor(const CameraRig& cameras, const EpipolarGeometry& epipolar,
                const ReconstructionOptions& options, const Skeleton& skeleton);

  // With a prediction, which decides conflicts and stands in for joints with
  // fewer than two views. Views in the order in which they joined the track;
  // older poses of a view follow its newest one, and each joint is taken from
  // the newest pose that has it.
  // Returns false when the update fails: fewer than two views, or too many
  // joints lost (`reconstruction` then tells what was found).
  bool Update(Span<UsedView> views, const Pose3d& predicted,
              Reconstruction* reconstruction);

  // Without a prediction: the initialisation rule of the filter with its own
  // threshold [px]. Joints with fewer than two views are missing.
  void Initialise(Span<UsedView> views, double alpha_px,
                  Reconstruction* reconstruction);

 private:
  bool KeepsEnough(const Reconstruction& reconstruction) const;
  // The steps of both, for all joints at a time.
  void Run(Span<UsedView> views, double alpha_px, const Pose3d* predicted,
           Reconstruction* reconstruction);
  void Reset(Span<UsedView> views, Reconstruction* reconstruction) const;
  void Gather(Span<UsedView> views);
  void FindConflicts(Span<UsedView> views, double alpha_px);
  void Filter(Span<UsedView> views, double alpha_px, const Pose3d* predicted,
              Reconstruction* reconstruction);
  void Triangulate(Span<UsedView> views);
  // The views that measure the joint, newest pose first within a view.
  void Measure(Span<UsedView> views, size_t joint_idx);
  TriangulationResult TriangulateAlone(Span<UsedView> views, size_t joint_idx);
  // Without the filter: every measured joint the detector believes in.
  void KeepConfident(Span<UsedView> views, size_t joint_idx);

  const CameraRig* cameras_;
  const EpipolarGeometry* epipolar_;
  JointsFilter filter_;
  ReconstructionOptions options_;
  std::vector<char> counts_;  // one a joint
  // Scratch of Run. Rows of lanes_ numbers, one a view; joints are lanes.
  size_t joints_ = 0;
  int lanes_ = 0;
  std::vector<double> x_px_;
  std::vector<double> y_px_;
  std::vector<double> present_;  // 1: the view measures the joint, else 0
  std::vector<LaneView> lane_views_;
  std::vector<double> conflict_;  // one a joint
  std::vector<double> point_m_;   // x, y, z of all joints in turn
  std::vector<double> found_;     // one a joint
  std::vector<char> seen_;        // one a joint: measured in this frame
  std::vector<int> views_of_;     // one a joint: how many measure it
  std::vector<double> view_weights_;
  // Of the joint at hand: the views that measured it.
  std::vector<int> measured_;
  std::vector<JointRay> rays_;
  std::vector<char> kept_;
  std::vector<PointMeasurement> measurements_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_RECONSTRUCTION_RECONSTRUCTION_H_
