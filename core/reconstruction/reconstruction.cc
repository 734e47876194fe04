#include "core/reconstruction/reconstruction.h"

#include <cmath>

namespace kinegraph {

void ReconstructionOptions::Describe(OptionVisitor& visitor) {
  // With the half frame of slack of FrameClock::Less, a view of this very frame
  // would not count below 1.
  visitor.Number("tau", &tau_frames, Between(1.0, 1e6), "frames",
                 "a view's newest 2D pose counts while younger than this");
  visitor.Number("lambda_t", &lambda_t_per_frame, NonNegative(), "1/frame",
                 "decay of an older view's weight in the DLT");
  visitor.Choice("newest", &newest, {"pose", "joint"},
                 "of a view: its newest 2D pose, or joint by joint");
  visitor.Boolean("incremental", &incremental,
                  "triangulate as each view is matched (cross_view)");
  visitor.Boolean("joints_filter", &joints_filter,
                  "remove views that contradict each other (Eq. 2-3)");
  visitor.Number("alpha_epi", &alpha_epi_px, Positive(), "px",
                 "epipolar distance at which two views contradict (Eq. 2)");
  visitor.Choice("conflict_order", &conflict_order, {"view", "worst_first"},
                 "which contradiction is settled first");
  visitor.Number("max_lost_share", &max_lost_share, Between(0.0, 1.0),
                 "share of joints",
                 "an update that loses more of the joints seen fails");
  visitor.Boolean("require_in_front", &require_in_front,
                  "a joint behind a camera that measured it is refused");
}

namespace {

bool FromTwoViews(Span<UsedView> views) {
  for (const UsedView& view : views) {
    if (view.observation->view_idx != views[0].observation->view_idx) {
      return true;
    }
  }
  return false;
}

}  // namespace

Reconstructor::Reconstructor(const CameraRig& cameras,
                             const EpipolarGeometry& epipolar,
                             const ReconstructionOptions& options,
                             const Skeleton& skeleton)
    : cameras_(&cameras),
      filter_(cameras, epipolar),
      options_(options),
      counts_(skeleton.joints().size(), 0) {
  for (const int j : skeleton.association_joints()) counts_[j] = 1;
}

bool Reconstructor::Update(Span<UsedView> views, const Pose3d& predicted,
                           Reconstruction* reconstruction) {
  Run(views, options_.alpha_epi_px, &predicted, reconstruction);
  if (!FromTwoViews(views)) return false;
  return reconstruction->lost_joints <=
         options_.max_lost_share * reconstruction->seen_joints;
}

void Reconstructor::Initialise(Span<UsedView> views, double alpha_px,
                               Reconstruction* reconstruction) {
  Run(views, alpha_px, nullptr, reconstruction);
}

void Reconstructor::KeepConfident(Span<UsedView> views, int joint_idx) {
  kept_.assign(measured_.size(), 0);
  for (size_t i = 0; i < measured_.size(); ++i) {
    const Observation& seen = *views[measured_[i]].observation;
    kept_[i] = seen.joints[joint_idx].confidence > 0.0;
  }
}

void Reconstructor::Run(Span<UsedView> views, double alpha_px,
                        const Pose3d* predicted,
                        Reconstruction* reconstruction) {
  const size_t joint_count =
      views.empty() ? 0 : views[0].observation->joints.size();
  reconstruction->pose.assign(joint_count, Joint3d());
  reconstruction->triangulated.assign(joint_count, 0);
  reconstruction->fresh_inlier_views.assign(joint_count, 0);
  reconstruction->verdicts.assign(views.size() * joint_count,
                                  FilterVerdict::kUnmeasured);
  reconstruction->seen_joints = 0;
  reconstruction->lost_joints = 0;
  view_weights_.resize(views.size());
  for (size_t v = 0; v < views.size(); ++v) {
    view_weights_[v] =
        views[v].fresh()
            ? 1.0
            : std::exp(-options_.lambda_t_per_frame * views[v].age_frames);
  }
  const bool initial = predicted == nullptr;
  TriangulationOptions triangulation_options;
  triangulation_options.require_in_front = options_.require_in_front;
  for (size_t j = 0; j < joint_count; ++j) {
    measured_.clear();
    rays_.clear();
    bool seen = false;
    for (size_t v = 0; v < views.size(); ++v) {
      const Observation& observation = *views[v].observation;
      if (!observation.joints[j].found) continue;
      // An older pose of the same view.
      if (!rays_.empty() && rays_.back().view_idx == observation.view_idx) {
        continue;
      }
      measured_.push_back(static_cast<int>(v));
      rays_.push_back({observation.view_idx, observation.ideal_px[j]});
      seen = seen || views[v].fresh();
    }
    const bool has_prediction = !initial && (*predicted)[j].present();
    // "Without the filter" means the update's; initialisation keeps its own.
    if (options_.joints_filter || initial) {
      filter_.Apply(rays_, alpha_px, options_.conflict_order,
                    has_prediction ? &(*predicted)[j].position_m : nullptr,
                    &kept_);
    } else {
      KeepConfident(views, static_cast<int>(j));
    }
    measurements_.clear();
    int fresh_kept = 0;
    for (size_t i = 0; i < measured_.size(); ++i) {
      const int v = measured_[i];
      reconstruction->verdicts[v * joint_count + j] =
          kept_[i] ? FilterVerdict::kKept : FilterVerdict::kRemoved;
      if (!kept_[i]) continue;
      measurements_.push_back({&(*cameras_)[rays_[i].view_idx],
                               rays_[i].ideal_px, view_weights_[v]});
      fresh_kept += views[v].fresh();
    }
    reconstruction->fresh_inlier_views[j] = fresh_kept;
    Joint3d& joint = reconstruction->pose[j];
    const TriangulationResult triangulation =
        TriangulateDlt(measurements_, triangulation_options);
    if (triangulation.ok()) {
      reconstruction->triangulated[j] = 1;
      joint.position_m = triangulation.point_m;
      joint.status =
          fresh_kept >= 2 ? JointStatus::kObserved : JointStatus::kInferred;
    } else if (has_prediction) {
      joint.position_m = (*predicted)[j].position_m;
      joint.status = JointStatus::kInferred;
    }
    if (!counts_[j] || !seen) continue;
    ++reconstruction->seen_joints;
    if (!triangulation.ok()) ++reconstruction->lost_joints;
  }
}

}  // namespace kinegraph
