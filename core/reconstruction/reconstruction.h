// A person's 3D pose from the 2D poses matched with them.
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

// One view's measurement of a joint.
struct JointRay {
  int view_idx = 0;
  Eigen::Vector2d ideal_px = Eigen::Vector2d::Zero();
};

// Selects the views of one joint (Eq. 2 and 3 of Chu et al. 2021). Two views
// are in conflict when E = 1 - distance / alpha < 0, with the mean of the two
// epipolar distances (Eq. 2). One of two conflicting views is removed:
// - with a predicted point, the one whose ray is farther from it (Eq. 3; on a
//   tie the second);
// - without, the one with the smaller row sum of E over all views (on a tie
//   the first; the sums are not recomputed).
// A pair is skipped when either view is already removed, so at least one view
// always remains. Reuses its memory between calls.
class JointsFilter {
 public:
  JointsFilter(const CameraRig& cameras, const EpipolarGeometry& epipolar)
      : cameras_(&cameras), epipolar_(&epipolar) {}

  // (*kept)[i] is whether rays[i] is kept. `predicted_m` may be null.
  void Apply(Span<JointRay> rays, double alpha_px, ConflictOrder order,
             const Eigen::Vector3d* predicted_m, std::vector<char>* kept);

 private:
  // The view to remove, of the conflicting views i < j.
  size_t Loser(Span<JointRay> rays, size_t i, size_t j,
               const Eigen::Vector3d* predicted_m) const;

  const CameraRig* cameras_;
  const EpipolarGeometry* epipolar_;
  std::vector<double> affinity_;  // E, row-major
};

// A 2D pose used in a reconstruction.
struct UsedView {
  const Observation* observation = nullptr;
  double age_frames = 0.0;  // 0: seen in this frame
  bool fresh() const { return age_frames == 0.0; }
};

struct Reconstruction {
  // kObserved: triangulated, with two or more views of this frame. kInferred:
  // triangulated with fewer, or predicted. kMissing: neither.
  Pose3d pose;
  std::vector<char> triangulated;       // one per joint
  std::vector<int> fresh_inlier_views;  // one per joint
  std::vector<FilterVerdict> verdicts;  // [view * joints + joint]
  // Numbers of association joints. Seen: measured in at least one view of this
  // frame. Lost: seen, but without a triangulation. Alone: lost, and measured
  // by a single view.
  int seen_joints = 0;
  int lost_joints = 0;
  int alone_joints = 0;
};

// Number of `joints` that were triangulated.
int CountTriangulated(const Reconstruction& reconstruction,
                      const std::vector<int>& joints);

// Joints filter, then weighted DLT, joint by joint. Reuses its memory between
// calls; not thread-safe.
class Reconstructor {
 public:
  // `cameras` and `epipolar` must outlive the object. `skeleton` is that of the
  // observations; its association joints are counted.
  Reconstructor(const CameraRig& cameras, const EpipolarGeometry& epipolar,
                const ReconstructionOptions& options, const Skeleton& skeleton);

  // Uses a prediction to decide conflicts and to replace joints that cannot be
  // triangulated. `views` are in the order in which they joined the track;
  // older poses of a view follow its newest one, and each joint is taken from
  // the newest pose that has it. Returns false when the update fails: fewer
  // than two views, or too many joints lost (`reconstruction` then holds the
  // partial result).
  bool Update(Span<UsedView> views, const Pose3d& predicted,
              Reconstruction* reconstruction);

  // Uses no prediction: the filter decides conflicts by its initialisation
  // rule, with a threshold of its own [px]. Joints that cannot be triangulated
  // are missing.
  void Initialise(Span<UsedView> views, double alpha_px,
                  Reconstruction* reconstruction);

 private:
  bool KeepsEnough(const Reconstruction& reconstruction) const;
  // The steps that Update and Initialise share, for all joints at once.
  void Run(Span<UsedView> views, double alpha_px, const Pose3d* predicted,
           Reconstruction* reconstruction);
  void Reset(Span<UsedView> views, Reconstruction* reconstruction) const;
  void Gather(Span<UsedView> views);
  void FindConflicts(Span<UsedView> views, double alpha_px);
  void Filter(Span<UsedView> views, double alpha_px, const Pose3d* predicted,
              Reconstruction* reconstruction);
  void Triangulate(Span<UsedView> views);
  // Lists the poses that measure the joint, at most one per view, in measured_
  // and rays_.
  void Measure(Span<UsedView> views, size_t joint_idx);
  // For a joint whose triangulation in lanes did not converge.
  TriangulationResult TriangulateAlone(Span<UsedView> views, size_t joint_idx);
  // In place of the filter: keeps every measurement with a confidence above 0.
  void KeepConfident(Span<UsedView> views, size_t joint_idx);

  const CameraRig* cameras_;
  const EpipolarGeometry* epipolar_;
  JointsFilter filter_;
  ReconstructionOptions options_;
  TriangulationOptions triangulation_;
  std::vector<char> counts_;  // one per joint: 1 for association joints
  // Buffers of Run. Rows of lanes_ numbers, one row per view; one joint per
  // lane.
  size_t joints_ = 0;
  int lanes_ = 0;
  std::vector<double> x_px_;
  std::vector<double> y_px_;
  std::vector<double> present_;  // 1: the view measures the joint, else 0
  std::vector<LaneView> lane_views_;
  std::vector<double> conflict_;  // one per joint
  std::vector<double> point_m_;   // x of all joints, then y, then z
  std::vector<double> found_;     // one per joint, as LanePoints::found
  std::vector<char> seen_;        // one per joint: measured in this frame
  // One per joint: number of views that measure it.
  std::vector<int> views_of_;
  // For the current joint: the views that measured it.
  std::vector<int> measured_;
  std::vector<JointRay> rays_;
  std::vector<char> kept_;
  std::vector<PointMeasurement> measurements_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_RECONSTRUCTION_RECONSTRUCTION_H_
