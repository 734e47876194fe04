#include "core/data/pose_check.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace kinegraph {
namespace {

// A billion: what goes beyond is an overflow, not a place.
constexpr double kFarthest = 1e9;  // times the extent of the cameras
// Of the largest entry: rounding of sums and products.
constexpr double kRounding = 1e-9;

bool IsCovariance(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return false;
  const double slack = kRounding * covariance.cwiseAbs().maxCoeff();
  if (!((covariance - covariance.transpose()).cwiseAbs().maxCoeff() <= slack)) {
    return false;
  }
  // The cheap test first; a covariance of rank two passes by its eigenvalues.
  if (Eigen::LLT<Eigen::Matrix3d>(covariance).info() == Eigen::Success) {
    return true;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      covariance, Eigen::EigenvaluesOnly);
  return covariance.trace() > 0.0 && solver.eigenvalues().minCoeff() >= -slack;
}

}  // namespace

PoseCheck::PoseCheck(const CameraRig& cameras) {
  for (const Camera& camera : cameras) {
    centre_m_ += camera.centre() / static_cast<double>(cameras.size());
  }
  for (const Camera& camera : cameras) {
    farthest_m_ =
        std::max(farthest_m_, kFarthest * (camera.centre() - centre_m_).norm());
  }
  // Cameras in one place have no extent.
  if (farthest_m_ == 0.0) farthest_m_ = std::numeric_limits<double>::max();
}

void PoseCheck::Require(const TrackHeader& header,
                        const TrackFrame& frame) const {
  for (const PersonPose& person : frame.people) {
    const auto fail = [&](size_t j, const char* what) {
      throw std::logic_error("frame " + std::to_string(frame.frame) +
                             ", person " + std::to_string(person.id.value()) +
                             ", " + header.skeleton.joints()[j] + ": " + what +
                             "; this is a fault of kinegraph, please report "
                             "it with the recording");
    };
    for (size_t j = 0; j < person.joints.size(); ++j) {
      const Joint3d& joint = person.joints[j];
      if (!joint.present()) continue;
      // Not so for what is not finite, either.
      if (!((joint.position_m - centre_m_).norm() <= farthest_m_)) {
        fail(j, "the position is no place in the scene");
      }
    }
    for (size_t j = 0; j < person.covariances.size(); ++j) {
      if (!person.covariances[j].has_value()) continue;
      if (!IsCovariance(*person.covariances[j])) {
        fail(j, "the covariance is not positive definite");
      }
    }
  }
}

}  // namespace kinegraph
