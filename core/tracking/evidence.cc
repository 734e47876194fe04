#include "core/tracking/evidence.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {

int MemoryDepth(const ReconstructionOptions& options) {
  return options.newest == NewestRule::kJoint
             ? static_cast<int>(std::ceil(options.tau_frames))
             : 1;
}

void FillEstimatorFrame(const std::vector<UsedView>& used,
                        const Reconstruction& reconstruction, bool succeeded,
                        EstimatorFrame* frame) {
  const size_t joints = reconstruction.pose.size();
  size_t count = 0;
  for (size_t v = 0; v < used.size(); ++v) {
    if (!used[v].fresh()) continue;
    if (count == frame->views.size()) frame->views.emplace_back();
    FreshView& view = frame->views[count++];
    view.view_idx = used[v].observation->view_idx;
    view.capture_time = used[v].observation->capture_time;
    view.detection_idx = used[v].observation->detection_idx;
    view.joints = used[v].observation->joints;
    const auto verdicts =
        reconstruction.verdicts.begin() + static_cast<long>(v * joints);
    view.verdicts.assign(verdicts, verdicts + static_cast<long>(joints));
  }
  frame->views.resize(count);
  frame->inlier_views = reconstruction.fresh_inlier_views;
  frame->triangulated = reconstruction.triangulated;
  frame->has_initial = succeeded;
  if (succeeded) frame->initial = reconstruction.pose;
}

EvidenceStep::EvidenceStep(const SceneModel& scene,
                           const EpipolarGeometry& epipolar,
                           const TrackerOptions& options)
    : joint_count_(scene.skeleton.joint_count()),
      clock_(scene.frame_rate_hz),
      tau_frames_(options.reconstruction.tau_frames),
      alpha_new_px_(options.initialisation.alpha_filter_px),
      association_joints_(scene.skeleton.association_joints()),
      min_new_joints_(
          std::max(1, ScaledJoints(options.initialisation.min_joints,
                                   association_joints_.size()))),
      reconstructor_(scene.cameras, epipolar, options.reconstruction,
                     scene.skeleton) {}

void EvidenceStep::Begin(int64_t frame, TimeNs time,
                         EstimatorFrame* evidence) const {
  evidence->frame = frame;
  evidence->time = time;
  evidence->has_initial = false;
  evidence->views.clear();
  evidence->inlier_views.assign(joint_count_, 0);
  evidence->triangulated.assign(joint_count_, 0);
}

const std::vector<UsedView>& EvidenceStep::YoungViews(const ViewMemory& memory,
                                                      TimeNs time) {
  views_.clear();
  for (const ViewMemory::Entry& entry : memory.entries()) {
    const TimeNs age = time - entry.frame_time;
    if (!clock_.Less(age, tau_frames_)) continue;
    views_.push_back({&entry.observation, clock_.Frames(age)});
  }
  return views_;
}

bool EvidenceStep::Update(const std::vector<UsedView>& views,
                          const Pose3d& predicted, EstimatorFrame* evidence) {
  const bool succeeded = TryUpdate(views, predicted);
  FillEstimatorFrame(views, reconstruction_, succeeded, evidence);
  return succeeded;
}

bool EvidenceStep::Initialise(const std::vector<UsedView>& views,
                              EstimatorFrame* evidence) {
  if (views.size() < 2) return false;
  reconstructor_.Initialise(views, alpha_new_px_, &reconstruction_);
  if (CountTriangulated(reconstruction_, association_joints_) <
      min_new_joints_) {
    return false;
  }
  FillEstimatorFrame(views, reconstruction_, /*succeeded=*/true, evidence);
  return true;
}

bool EvidenceStep::TryUpdate(const std::vector<UsedView>& views,
                             const Pose3d& predicted) {
  return reconstructor_.Update(views, predicted, &reconstruction_);
}

}  // namespace kinegraph
