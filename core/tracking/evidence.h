// The step between matching and estimating, which tracker, replay and second
// pass share: views and a prediction, joints filter and DLT, evidence for the
// estimator.
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

// Writes what a reconstruction says into an estimator's frame: the fresh views
// with their verdicts, inlier views, and the pose if `succeeded`. The frame's
// number and time are the caller's.
void FillEstimatorFrame(const std::vector<UsedView>& used,
                        const Reconstruction& reconstruction, bool succeeded,
                        EstimatorFrame* frame);

// Keeps its memory between frames; one a thread.
class EvidenceStep {
 public:
  // `scene` and `epipolar` must outlive the object. Options with the gates of
  // the scene (WithScaledGates).
  EvidenceStep(const SceneModel& scene, const EpipolarGeometry& epipolar,
               const TrackerOptions& options);

  // A frame in which nothing was matched: the estimator predicts.
  void Begin(int64_t frame, TimeNs time, EstimatorFrame* evidence) const;

  // The poses of a memory that are young enough at `time`.
  const std::vector<UsedView>& YoungViews(const ViewMemory& memory,
                                          TimeNs time);

  // Joints filter and DLT with `predicted` deciding conflicts. False where the
  // update fails: the evidence then has views and no pose.
  bool Update(const std::vector<UsedView>& views, const Pose3d& predicted,
              EstimatorFrame* evidence);
  // The same without a prediction: somebody new. Fails with fewer joints
  // triangulated than a new person must have.
  bool Initialise(const std::vector<UsedView>& views, EstimatorFrame* evidence);
  // Without evidence: whether the views agree, and on what.
  bool Look(const std::vector<UsedView>& views, const Pose3d& predicted);

  // Of the last call.
  const Reconstruction& reconstruction() const { return reconstruction_; }
  Reconstructor& reconstructor() { return reconstructor_; }

 private:
  size_t joint_count_;
  FrameClock clock_;
  double tau_frames_;  // older views do not count
  double alpha_new_px_;
  const std::vector<int>& association_joints_;
  int min_new_joints_;
  Reconstructor reconstructor_;
  std::vector<UsedView> views_;
  Reconstruction reconstruction_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_EVIDENCE_H_
