#include "apps/report/pose_arrays.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "apps/report/page.h"

namespace kinegraph {
namespace {

constexpr double kQuantumM = 1e-4;
constexpr double kResidualQuantumPx = 0.1;
constexpr double kDifferenceQuantumM = 1e-3;
constexpr uint16_t kNoValue16 = 65535;
constexpr uint8_t kNoWeight = 255;
constexpr double kWeightSteps = 200.0;

double LargestReach(const TrackSequence& tracks) {
  double reach = 0.0;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      const auto middle = MeanPosition(person.joints);
      if (!middle.has_value()) continue;
      for (const Joint3d& joint : person.joints) {
        if (!joint.present()) continue;
        reach =
            std::max(reach, (joint.position_m - *middle).cwiseAbs().maxCoeff());
      }
    }
  }
  return reach;
}

}  // namespace

PoseArrays::PoseArrays(const TrackSequence& tracks, size_t view_count)
    : quantum_m_(std::max(kQuantumM, LargestReach(tracks) / 32000.0)),
      view_count_(view_count) {}

void PoseArrays::Add(const PersonPose& person, uint32_t frame,
                     uint16_t person_idx) {
  const Eigen::Vector3d middle =
      MeanPosition(person.joints).value_or(Eigen::Vector3d::Zero());
  Eigen::Vector3d root_m;
  for (int k = 0; k < 3; ++k) {
    root_.push_back(Quantise<int32_t>(middle[k], kQuantumM));
    root_m[k] = root_.back() * kQuantumM;
  }
  frame_.push_back(frame);
  person_.push_back(person_idx);
  for (size_t j = 0; j < person.joints.size(); ++j) {
    const Joint3d& joint = person.joints[j];
    const Eigen::Vector3d offset =
        joint.present() ? Eigen::Vector3d(joint.position_m - root_m)
                        : Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      joints_.push_back(Quantise<int16_t>(offset[k], quantum_m_));
    }
    const int views = j < person.inlier_views.size()
                          ? std::min(person.inlier_views[j], 63)
                          : 0;
    status_.push_back(
        static_cast<uint8_t>(static_cast<int>(joint.status) + 4 * views));
  }
}

void PoseArrays::AddResiduals(const std::vector<ViewPair>& pairs) {
  for (const ViewPair& pair : pairs) {
    residual_.push_back(
        !pair.residual_px.has_value()
            ? kNoValue16
            : std::min<uint16_t>(
                  Quantise<uint16_t>(*pair.residual_px, kResidualQuantumPx),
                  kNoValue16 - 1));
  }
}

void PoseArrays::AddDifference(double difference_m) {
  difference_.push_back(
      difference_m < 0.0
          ? kNoValue16
          : Quantise<uint16_t>(difference_m, kDifferenceQuantumM));
}

void PoseArrays::AddMatches(const PersonPose& person,
                            const std::vector<ViewPair>& pairs,
                            const DetectionPairing& pairing) {
  const size_t joint_count = person.joints.size();
  const size_t at = weight_.size();
  weight_.resize(at + view_count_ * joint_count, kNoWeight);
  for (const ViewPair& pair : pairs) {
    match_.push_back(static_cast<int16_t>(pair.detection));
  }
  for (const ViewMatch& match : person.matches) {
    const int view = pairing.ViewOf(match.view_idx);
    if (view < 0) continue;
    for (size_t j = 0; j < match.weights.size(); ++j) {
      if (!match.weights[j].has_value()) continue;
      const double weight = std::clamp(*match.weights[j], 0.0, 1.0);
      // Rounded up, so that only a weight of zero is stored as 0.
      weight_[at + static_cast<size_t>(view) * joint_count + j] =
          static_cast<uint8_t>(std::ceil(weight * kWeightSteps));
    }
  }
}

// The lower Cholesky factor maps the unit sphere to the one-sigma ellipsoid.
void PoseArrays::AddCovariances(const PersonPose& person) {
  for (size_t j = 0; j < person.joints.size(); ++j) {
    Eigen::Matrix3d factor = Eigen::Matrix3d::Zero();
    if (j < person.covariances.size() && person.covariances[j].has_value()) {
      const Eigen::LLT<Eigen::Matrix3d> llt(*person.covariances[j]);
      if (llt.info() == Eigen::Success) factor = llt.matrixL();
    }
    for (const auto& [row, column] :
         {std::pair{0, 0}, {1, 0}, {1, 1}, {2, 0}, {2, 1}, {2, 2}}) {
      covariance_.push_back(Quantise<int16_t>(factor(row, column), kQuantumM));
    }
  }
}

void PoseArrays::PosesTo(Json* json) const {
  (*json)["rootQuantum"] = kQuantumM;
  (*json)["quantum"] = quantum_m_;
  (*json)["frame"] = Base64(frame_);
  (*json)["person"] = Base64(person_);
  (*json)["root"] = Base64(root_);
  (*json)["joints"] = Base64(joints_);
  (*json)["status"] = Base64(status_);
}

void PoseArrays::DetailsTo(Json* json, PageData* data) const {
  const auto add = [json](const char* key, const auto& numbers) {
    if (numbers.empty()) return size_t{0};
    std::string text = Base64(numbers);
    const size_t bytes = text.size();
    (*json)[key] = std::move(text);
    return bytes;
  };
  const size_t residual_bytes = add("residual", residual_);
  add("difference", difference_);
  if (!match_.empty()) {
    data->detection_bytes += residual_bytes;
    data->detection_bytes += add("match", match_);
    data->detection_bytes += add("weight", weight_);
  }
  const bool has_covariance =
      std::any_of(covariance_.begin(), covariance_.end(),
                  [](int16_t value) { return value != 0; });
  if (has_covariance) data->covariance_bytes += add("covariance", covariance_);
}

}  // namespace kinegraph
