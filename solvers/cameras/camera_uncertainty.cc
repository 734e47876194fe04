#include "solvers/cameras/camera_uncertainty.h"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "solvers/cameras/camera_change.h"
#include "solvers/cameras/segments.h"

namespace kinegraph {

CameraUncertainty::CameraUncertainty(CameraRig cameras,
                                     std::vector<std::vector<int>> places,
                                     Eigen::MatrixXd covariance,
                                     std::vector<int> detection_joint,
                                     double clock_zero_s)
    : cameras_(std::move(cameras)),
      places_(std::move(places)),
      covariance_(std::move(covariance)),
      detection_joint_(std::move(detection_joint)),
      clock_zero_s_(clock_zero_s) {
  Eigen::Index size = 0;
  for (const std::vector<int>& list : places_) {
    begin_.push_back(size);
    size += static_cast<Eigen::Index>(list.size());
  }
}

std::optional<CameraUncertainty::Sensitivity> CameraUncertainty::Of(
    const DetectionFrame& seen, const PersonPose& person, size_t joint,
    const Eigen::Vector3d& velocity_mps, double since_s) const {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Sensitivity cross = Sensitivity::Zero(3, covariance_.rows());
  int views = 0;
  for (const ViewMatch& match : person.matches) {
    if (joint >= match.weights.size() || !match.weights[joint].has_value()) {
      continue;
    }
    const auto v = static_cast<size_t>(match.view_idx);
    const Detection* detection =
        FindDetection(seen.views[v], match.detection_idx);
    if (detection == nullptr) continue;
    const Keypoint& keypoint = detection->joints[detection_joint_[joint]];
    const Eigen::Vector3d& point = person.joints[joint].position_m;
    Matrix23d by_point;
    Eigen::Matrix<double, 2, kChangeSize> by_change;
    if (!ProjectChanged(cameras_[v], CameraChange::Zero(), point, &by_point,
                        &by_change)) {
      continue;
    }
    by_change.col(kOffsetAt) = by_point * velocity_mps;
    by_change.col(kDriftAt) = since_s * by_change.col(kOffsetAt);
    // Pixel noise is proportional to a person's size in the image.
    const double sigma = cameras_[v].focal_px() / cameras_[v].Depth(point);
    const double weight = *match.weights[joint] *
                          std::clamp(keypoint.confidence, 0.05, 1.0) /
                          (sigma * sigma);
    if (!(weight > 0.0)) continue;
    information += weight * by_point.transpose() * by_point;
    for (size_t i = 0; i < places_[v].size(); ++i) {
      cross.col(begin_[v] + static_cast<Eigen::Index>(i)) +=
          weight * by_point.transpose() * by_change.col(places_[v][i]);
    }
    ++views;
  }
  if (views < 2) return std::nullopt;
  // Nearly parallel rays do not determine the depth, which then follows from
  // the motion model, represented here by a thousandth of the mean information.
  information.diagonal().array() += 1e-3 * information.trace() / 3.0;
  return -information.inverse() * cross;
}

Eigen::Vector3d CameraUncertainty::VelocityOf(const PersonPose& person,
                                              size_t joint,
                                              double passed_s) const {
  const auto at = last_.find(person.id);
  if (at == last_.end() || !(passed_s > 0.0) ||
      !at->second.joints[joint].present()) {
    return Eigen::Vector3d::Zero();
  }
  return (person.joints[joint].position_m -
          at->second.joints[joint].position_m) /
         passed_s;
}

void CameraUncertainty::AddToPerson(const DetectionFrame& seen, double passed_s,
                                    double since_s, PersonPose* person) const {
  const size_t count =
      std::min(person->covariances.size(), detection_joint_.size());
  std::vector<size_t> left;
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  double known = 0.0;
  for (size_t j = 0; j < count; ++j) {
    if (!person->covariances[j].has_value()) continue;
    left.push_back(j);
    if (detection_joint_[j] < 0) continue;
    const auto sensitivity =
        Of(seen, *person, j, VelocityOf(*person, j, passed_s), since_s);
    if (!sensitivity.has_value()) continue;
    const Eigen::Matrix3d added =
        *sensitivity * covariance_ * sensitivity->transpose();
    *person->covariances[j] += added;
    mean += added;
    known += 1.0;
    left.pop_back();
  }
  // Joints observed by fewer than two views receive the mean addition of the
  // others.
  if (known == 0.0) return;
  for (const size_t j : left) *person->covariances[j] += mean / known;
}

void CameraUncertainty::AddTo(const DetectionFrame& seen, TrackFrame* frame) {
  std::map<TrackId, Last> now;
  for (PersonPose& person : frame->people) {
    const auto before = last_.find(person.id);
    const double passed_s = before == last_.end()
                                ? 0.0
                                : ToSeconds(frame->time - before->second.time);
    AddToPerson(seen, passed_s, ToSeconds(frame->time) - clock_zero_s_,
                &person);
    now[person.id] = {frame->time, person.joints};
  }
  last_ = std::move(now);
}

}  // namespace kinegraph
