#include "core/reconstruction/joints_filter.h"

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

}  // namespace kinegraph
