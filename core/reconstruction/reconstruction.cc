#include "core/reconstruction/reconstruction.h"

#include <algorithm>
#include <cmath>

#include "core/base/pack.h"

namespace kinegraph {

size_t JointsFilter::Loser(Span<JointRay> rays, size_t i, size_t j,
                           const Eigen::Vector3d* predicted_m) const {
  if (predicted_m != nullptr) {
    // Eq. 3: the distance of the predicted joint from the back-projected ray.
    const double distance_i = DistanceToRay((*cameras_)[rays[i].view_idx],
                                            rays[i].ideal_px, *predicted_m);
    const double distance_j = DistanceToRay((*cameras_)[rays[j].view_idx],
                                            rays[j].ideal_px, *predicted_m);
    return distance_i > distance_j ? i : j;
  }
  const size_t count = rays.size();
  double sum_i = 0.0;
  double sum_j = 0.0;
  for (size_t k = 0; k < count; ++k) {
    sum_i += affinity_[i * count + k];
    sum_j += affinity_[j * count + k];
  }
  return sum_j < sum_i ? j : i;
}

void JointsFilter::Apply(Span<JointRay> rays, double alpha_px,
                         ConflictOrder order,
                         const Eigen::Vector3d* predicted_m,
                         std::vector<char>* kept) {
  const size_t count = rays.size();
  kept->assign(count, 1);
  // The diagonal is E of a point with itself: distance 0.
  affinity_.assign(count * count, 1.0);
  bool conflict = false;
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = i + 1; j < count; ++j) {
      // Eq. 2: E_ij = 1 - (d(x_i, L_j) + d(x_j, L_i)) / (2 alpha_epi).
      const double distance_px =
          epipolar_->Distance(rays[i].view_idx, rays[i].ideal_px,
                              rays[j].view_idx, rays[j].ideal_px);
      const double affinity = 1.0 - distance_px / alpha_px;
      affinity_[i * count + j] = affinity;
      affinity_[j * count + i] = affinity;
      conflict = conflict || affinity < 0.0;
    }
  }
  if (!conflict) return;
  if (order == ConflictOrder::kView) {
    for (size_t i = 0; i < count; ++i) {
      for (size_t j = i + 1; j < count; ++j) {
        if (!(*kept)[i] || !(*kept)[j]) continue;
        if (!(affinity_[i * count + j] < 0.0)) continue;
        (*kept)[Loser(rays, i, j, predicted_m)] = 0;
      }
    }
    return;
  }
  while (true) {
    double worst = 0.0;
    size_t worst_i = 0;
    size_t worst_j = 0;
    for (size_t i = 0; i < count; ++i) {
      for (size_t j = i + 1; j < count; ++j) {
        if (!(*kept)[i] || !(*kept)[j]) continue;
        if (affinity_[i * count + j] < worst) {
          worst = affinity_[i * count + j];
          worst_i = i;
          worst_j = j;
        }
      }
    }
    if (!(worst < 0.0)) return;
    (*kept)[Loser(rays, worst_i, worst_j, predicted_m)] = 0;
  }
}

int CountTriangulated(const Reconstruction& reconstruction,
                      const std::vector<int>& joints) {
  return static_cast<int>(std::count_if(
      joints.begin(), joints.end(),
      [&](int j) { return reconstruction.triangulated[j] != 0; }));
}

void ReconstructionOptions::Describe(OptionVisitor& visitor) {
  // At least 1: with the half frame of tolerance of FrameClock::Less, a value
  // of 0.5 or less would exclude even the views of the current frame.
  visitor.Number("tau", &tau_frames, Between(1.0, 1e6), "frames",
                 "a view's newest 2D pose is used while younger than this");
  visitor.Number("lambda_t", &lambda_t_per_frame, NonNegative(), "1/frame",
                 "decay of an older view's weight in the DLT");
  visitor.Choice("newest", &newest, {"pose", "joint"},
                 "what is used of each view: its newest 2D pose, or the newest "
                 "measurement of each joint");
  visitor.Boolean("incremental", &incremental,
                  "triangulate as each view is matched (cross_view)");
  visitor.Boolean("joints_filter", &joints_filter,
                  "remove views that contradict each other (Eq. 2-3)");
  visitor.Number("alpha_epi", &alpha_epi_px, Positive(), "px",
                 "epipolar distance beyond which two views conflict (Eq. 2)");
  visitor.Choice("conflict_order", &conflict_order, {"view", "worst_first"},
                 "which conflict is resolved first");
  visitor.Number("max_lost_share", &max_lost_share, Between(0.0, 1.0),
                 "share of joints",
                 "an update fails if it loses more of the joints seen");
  visitor.Choice(
      "lost", &lost, {"seen", "contradicted"},
      "graph mode: untriangulated joints that count as lost: all that are seen "
      "(as in paper mode), or those whose views contradict each other");
  visitor.Boolean("require_in_front", &require_in_front,
                  "reject joints behind a camera that measured them");
}

Reconstructor::Reconstructor(const CameraRig& cameras,
                             const EpipolarGeometry& epipolar,
                             const ReconstructionOptions& options,
                             const Skeleton& skeleton)
    : cameras_(&cameras),
      epipolar_(&epipolar),
      filter_(cameras, epipolar),
      options_(options),
      counts_(skeleton.joints().size(), 0) {
  triangulation_.require_in_front = options.require_in_front;
  for (const int j : skeleton.association_joints()) counts_[j] = 1;
}

bool Reconstructor::Update(Span<UsedView> views, const Pose3d& predicted,
                           Reconstruction* reconstruction) {
  Run(views, options_.alpha_epi_px, &predicted, reconstruction);
  const bool from_two_views =
      std::any_of(views.begin(), views.end(), [&](const UsedView& view) {
        return view.observation->view_idx != views[0].observation->view_idx;
      });
  return from_two_views && KeepsEnough(*reconstruction);
}

bool Reconstructor::KeepsEnough(const Reconstruction& reconstruction) const {
  const int seen = reconstruction.seen_joints;
  const int lost = reconstruction.lost_joints;
  if (options_.lost == LostRule::kSeen) {
    return lost <= options_.max_lost_share * seen;
  }
  // Views with hardly any joint in common do not show one person. If two views
  // miss half of the joints each, independently, a third of the joints seen is
  // in both.
  constexpr double kLeastShared = 0.25;
  const int alone = reconstruction.alone_joints;
  // One joint may always be lost: of a person's bounding box, whose joints are
  // its top and bottom, the bottom may be hidden.
  const double most = std::max(1.0, options_.max_lost_share * (seen - alone));
  return seen - lost >= kLeastShared * seen && lost < seen &&
         lost - alone <= most;
}

void Reconstructor::Initialise(Span<UsedView> views, double alpha_px,
                               Reconstruction* reconstruction) {
  Run(views, alpha_px, nullptr, reconstruction);
}

void Reconstructor::Reset(Span<UsedView> views,
                          Reconstruction* reconstruction) const {
  reconstruction->pose.assign(joints_, Joint3d());
  reconstruction->triangulated.assign(joints_, 0);
  reconstruction->fresh_inlier_views.assign(joints_, 0);
  reconstruction->verdicts.assign(views.size() * joints_,
                                  FilterVerdict::kUnmeasured);
  reconstruction->seen_joints = 0;
  reconstruction->lost_joints = 0;
  reconstruction->alone_joints = 0;
}

// Copies the pixels of all joints and views into rows of lanes.
void Reconstructor::Gather(Span<UsedView> views) {
  const size_t size = views.size() * lanes_;
  x_px_.assign(size, 0.0);
  y_px_.assign(size, 0.0);
  present_.assign(size, 0.0);
  seen_.assign(joints_, 0);
  views_of_.assign(joints_, 0);
  lane_views_.resize(views.size());
  for (size_t v = 0; v < views.size(); ++v) {
    const UsedView& view = views[v];
    const Observation& observation = *view.observation;
    const double weight =
        view.fresh() ? 1.0
                     : std::exp(-options_.lambda_t_per_frame * view.age_frames);
    const size_t row = v * lanes_;
    for (size_t j = 0; j < joints_; ++j) {
      if (!observation.joints[j].found) continue;
      bool newest = true;  // false: a newer pose of the same view has the joint
      for (size_t other = v; newest && other-- > 0;) {
        const Observation& earlier = *views[other].observation;
        if (earlier.view_idx != observation.view_idx) break;
        newest = !earlier.joints[j].found;
      }
      if (!newest) continue;
      x_px_[row + j] = observation.ideal_px[j].x();
      y_px_[row + j] = observation.ideal_px[j].y();
      present_[row + j] = 1.0;
      seen_[j] |= view.fresh();
      ++views_of_[j];
    }
    const Camera& camera = (*cameras_)[observation.view_idx];
    lane_views_[v] = {camera.P().data(), camera.centre().data(), &x_px_[row],
                      &y_px_[row],       &present_[row],         weight};
  }
}

void Reconstructor::FindConflicts(Span<UsedView> views, double alpha_px) {
  conflict_.assign(lanes_, 0.0);
  for (size_t i = 0; i < views.size(); ++i) {
    for (size_t j = i + 1; j < views.size(); ++j) {
      MarkConflicts(lane_views_[i], lane_views_[j],
                    epipolar_->fundamental(views[i].observation->view_idx,
                                           views[j].observation->view_idx),
                    alpha_px, lanes_, conflict_.data());
    }
  }
}

void Reconstructor::Measure(Span<UsedView> views, size_t joint_idx) {
  measured_.clear();
  rays_.clear();
  for (size_t v = 0; v < views.size(); ++v) {
    if (present_[v * lanes_ + joint_idx] == 0.0) continue;
    const Observation& observation = *views[v].observation;
    measured_.push_back(static_cast<int>(v));
    rays_.push_back({observation.view_idx, observation.ideal_px[joint_idx]});
  }
}

void Reconstructor::KeepConfident(Span<UsedView> views, size_t joint_idx) {
  kept_.assign(measured_.size(), 0);
  for (size_t i = 0; i < measured_.size(); ++i) {
    const Observation& seen = *views[measured_[i]].observation;
    kept_[i] = seen.joints[joint_idx].confidence > 0.0;
  }
}

// Marks removed joints as not present and stores the verdicts.
void Reconstructor::Filter(Span<UsedView> views, double alpha_px,
                           const Pose3d* predicted,
                           Reconstruction* reconstruction) {
  // Disabling the filter only affects updates; initialisation always uses it.
  const bool filters = options_.joints_filter || predicted == nullptr;
  if (filters) FindConflicts(views, alpha_px);
  for (size_t j = 0; j < joints_; ++j) {
    if (!filters || conflict_[j] != 0.0) {
      Measure(views, j);
      if (filters) {
        const bool has_prediction =
            predicted != nullptr && (*predicted)[j].present();
        filter_.Apply(rays_, alpha_px, options_.conflict_order,
                      has_prediction ? &(*predicted)[j].position_m : nullptr,
                      &kept_);
      } else {
        KeepConfident(views, j);
      }
      for (size_t i = 0; i < measured_.size(); ++i) {
        if (kept_[i]) continue;
        present_[measured_[i] * lanes_ + j] = 0.0;
        reconstruction->verdicts[measured_[i] * joints_ + j] =
            FilterVerdict::kRemoved;
      }
    }
    for (size_t v = 0; v < views.size(); ++v) {
      if (present_[v * lanes_ + j] == 0.0) continue;
      reconstruction->verdicts[v * joints_ + j] = FilterVerdict::kKept;
      reconstruction->fresh_inlier_views[j] += views[v].fresh();
    }
  }
}

TriangulationResult Reconstructor::TriangulateAlone(Span<UsedView> views,
                                                    size_t joint_idx) {
  Measure(views, joint_idx);
  measurements_.clear();
  for (size_t i = 0; i < measured_.size(); ++i) {
    measurements_.push_back({&(*cameras_)[rays_[i].view_idx], rays_[i].ideal_px,
                             lane_views_[measured_[i]].weight});
  }
  return TriangulateDlt(measurements_, triangulation_);
}

void Reconstructor::Triangulate(Span<UsedView> views) {
  point_m_.resize(3 * static_cast<size_t>(lanes_));
  found_.resize(lanes_);
  double* x_m = point_m_.data();
  TriangulateLanes(lane_views_.data(), static_cast<int>(views.size()), lanes_,
                   triangulation_,
                   {x_m, x_m + lanes_, x_m + 2 * lanes_, found_.data()});
  for (size_t j = 0; j < joints_; ++j) {
    if (found_[j] >= 0.0) continue;
    const TriangulationResult alone = TriangulateAlone(views, j);
    found_[j] = alone.ok() ? 1.0 : 0.0;
    for (int i = 0; i < 3; ++i) x_m[i * lanes_ + j] = alone.point_m[i];
  }
}

void Reconstructor::Run(Span<UsedView> views, double alpha_px,
                        const Pose3d* predicted,
                        Reconstruction* reconstruction) {
  joints_ = views.empty() ? 0 : views[0].observation->joints.size();
  lanes_ = PaddedLanes(static_cast<int>(joints_));
  Reset(views, reconstruction);
  if (joints_ == 0) return;
  Gather(views);
  Filter(views, alpha_px, predicted, reconstruction);
  Triangulate(views);
  for (size_t j = 0; j < joints_; ++j) {
    const bool found = found_[j] > 0.0;
    Joint3d& joint = reconstruction->pose[j];
    if (found) {
      reconstruction->triangulated[j] = 1;
      joint.position_m = {point_m_[j], point_m_[lanes_ + j],
                          point_m_[2 * lanes_ + j]};
      joint.status = reconstruction->fresh_inlier_views[j] >= 2
                         ? JointStatus::kObserved
                         : JointStatus::kInferred;
    } else if (predicted != nullptr && (*predicted)[j].present()) {
      joint.position_m = (*predicted)[j].position_m;
      joint.status = JointStatus::kInferred;
    }
    if (!counts_[j] || !seen_[j]) continue;
    ++reconstruction->seen_joints;
    if (found) continue;
    ++reconstruction->lost_joints;
    if (views_of_[j] < 2) ++reconstruction->alone_joints;
  }
}

}  // namespace kinegraph
