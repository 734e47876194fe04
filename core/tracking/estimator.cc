#include "core/tracking/estimator.h"

#include <Eigen/Core>
#include <algorithm>
#include <iterator>
#include <limits>
#include <vector>

namespace kinegraph {
namespace {

// The displacement with the smallest sum of distances from the others, as an
// approximation of their geometric median; zero if there are none.
Eigen::Vector3d MedianOf(const std::vector<Eigen::Vector3d>& displacements) {
  Eigen::Vector3d median = Eigen::Vector3d::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& one : displacements) {
    double sum = 0.0;
    for (const Eigen::Vector3d& other : displacements) {
      sum += (one - other).norm();
    }
    if (!(sum < least)) continue;
    least = sum;
    median = one;
  }
  return median;
}

std::optional<double> WeightOf(FilterVerdict verdict) {
  if (verdict == FilterVerdict::kUnmeasured) return std::nullopt;
  return verdict == FilterVerdict::kKept ? 1.0 : 0.0;
}

}  // namespace

void ExpectBody(const Estimator& estimator, TimeNs time, double horizon_s,
                Pose3d* pose) {
  const Pose3d& last = estimator.Last();
  const double elapsed_s = ToSeconds(time - estimator.LastTime());
  estimator.Predict(time, pose);
  std::vector<Eigen::Vector3d> displacements;
  displacements.reserve(last.size());
  for (size_t j = 0; j < last.size(); ++j) {
    if (!last[j].present() || !(*pose)[j].present()) continue;
    displacements.push_back((*pose)[j].position_m - last[j].position_m);
  }
  const double share = elapsed_s > horizon_s ? horizon_s / elapsed_s : 1.0;
  const Eigen::Vector3d moved_m = share * MedianOf(displacements);
  *pose = last;
  for (Joint3d& joint : *pose) {
    if (joint.present()) joint.position_m += moved_m;
  }
}

void DescribeViews(const EstimatorFrame& frame, KeptMatches kept,
                   PersonPose* person) {
  person->inlier_views = frame.inlier_views;
  if (kept == KeptMatches::kNone) return;
  double confidence_sum = 0.0;
  int measured = 0;
  for (const FreshView& view : frame.views) {
    ViewMatch match;
    match.view_idx = view.view_idx;
    match.detection_idx = view.detection_idx;
    for (size_t j = 0; j < view.verdicts.size(); ++j) {
      if (view.verdicts[j] == FilterVerdict::kUnmeasured) continue;
      confidence_sum += view.joints[j].confidence;
      ++measured;
    }
    if (kept == KeptMatches::kWeights) {
      match.weights.reserve(view.verdicts.size());
      for (const FilterVerdict verdict : view.verdicts) {
        match.weights.push_back(WeightOf(verdict));
      }
    }
    person->matches.push_back(std::move(match));
  }
  if (measured > 0) person->score = confidence_sum / measured;
}

void MoveFinals(std::vector<FinalPose>* from, std::vector<FinalPose>* to) {
  std::move(from->begin(), from->end(), std::back_inserter(*to));
  from->clear();
}

void ExpectUnmoved(const Pose3d& last, Pose3d* pose) {
  *pose = last;
  for (Joint3d& joint : *pose) {
    if (joint.present()) joint.status = JointStatus::kInferred;
  }
}

}  // namespace kinegraph
