// The step between matching and estimation, shared by tracker, replay and
// second pass: joints filter and DLT turn views and a prediction into the input
// of an estimator.
#ifndef KINEGRAPH_CORE_TRACKING_EVIDENCE_H_
#define KINEGRAPH_CORE_TRACKING_EVIDENCE_H_

#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "core/data/pose.h"
#include "core/geometry/epipolar.h"
#include "core/reconstruction/reconstruction.h"
#include "core/tracking/estimator.h"
#include "core/tracking/options.h"
#include "core/tracking/track.h"

namespace kinegraph {

// Number of 2D poses of each view that a track remembers (ViewMemory).
int MemoryDepth(const ReconstructionOptions& options);

// Copies a reconstruction into an estimator's frame: the fresh views with their
// verdicts, the inlier views, which joints were triangulated and, if
// `succeeded`, the pose. The caller sets frame number and time.
void FillEstimatorFrame(const std::vector<UsedView>& used,
                        const Reconstruction& reconstruction, bool succeeded,
                        EstimatorFrame* frame);

// Reuses its memory between frames; use one per thread.
class EvidenceStep {
 public:
  // `scene` and `epipolar` must outlive the object. `options` must have the
  // gates of the scene (WithScaledGates).
  EvidenceStep(const SceneModel& scene, const EpipolarGeometry& epipolar,
               const TrackerOptions& options);

  // Starts a frame without matches. The estimator predicts in it, unless Update
  // or Initialise then adds a pose.
  void Begin(int64_t frame, TimeNs time, EstimatorFrame* evidence) const;

  // The 2D poses in `memory` that are recent enough at `time`.
  const std::vector<UsedView>& YoungViews(const ViewMemory& memory,
                                          TimeNs time);

  // Joints filter and DLT; `predicted` decides conflicts. Returns false if the
  // update fails: the evidence then has views but no pose.
  bool Update(const std::vector<UsedView>& views, const Pose3d& predicted,
              EstimatorFrame* evidence);
  // Update for a new person, who has no prediction. Fails with fewer than two
  // views, or fewer triangulated joints than a new person must have; `evidence`
  // is then unchanged.
  bool Initialise(const std::vector<UsedView>& views, EstimatorFrame* evidence);
  // As Update, but fills only reconstruction().
  bool TryUpdate(const std::vector<UsedView>& views, const Pose3d& predicted);

  // Result of the last Update, Initialise or TryUpdate.
  const Reconstruction& reconstruction() const { return reconstruction_; }
  Reconstructor& reconstructor() { return reconstructor_; }

 private:
  size_t joint_count_;
  FrameClock clock_;
  double tau_frames_;  // views of this age or older are ignored
  double alpha_new_px_;
  const std::vector<int>& association_joints_;
  int min_new_joints_;
  Reconstructor reconstructor_;
  std::vector<UsedView> views_;
  Reconstruction reconstruction_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_EVIDENCE_H_
