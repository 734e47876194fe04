#include "core/evaluation/cameras.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double AngleDeg(const Matrix3d& R) {
  return Eigen::AngleAxisd(R).angle() * 180.0 / M_PI;
}

// true = scale R found + t.
struct WorldAlignment {
  double scale = 1.0;
  Matrix3d R = Matrix3d::Identity();
  Vector3d t = Vector3d::Zero();

  Vector3d operator*(const Vector3d& point) const {
    return scale * (R * point) + t;
  }
};

using CameraPairs = std::vector<std::pair<const Camera*, const Camera*>>;

// Whether the centres, given relative to their mean, are nearly collinear, so
// that the rotation about their line is undetermined.
bool OnALine(const Eigen::Matrix3Xd& from_mean) {
  constexpr double kWidth = 0.05;  // relative to the length
  const Matrix3d scatter = from_mean * from_mean.transpose();
  const Vector3d squares = Eigen::JacobiSVD<Matrix3d>(scatter).singularValues();
  return !(squares(1) > kWidth * kWidth * squares(0));
}

WorldAlignment Align(const CameraPairs& pairs, bool with_scale) {
  const auto count = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix3Xd truth(3, count);
  Eigen::Matrix3Xd found(3, count);
  Matrix3d turns = Matrix3d::Zero();
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& [expected, camera] = pairs[static_cast<size_t>(i)];
    truth.col(i) = expected->centre();
    found.col(i) = camera->centre();
    turns += expected->R().transpose() * camera->R();
  }
  const Vector3d true_mean = truth.rowwise().mean();
  const Vector3d found_mean = found.rowwise().mean();
  const Eigen::Matrix3Xd from_mean = found.colwise() - found_mean;
  const Eigen::Matrix3Xd true_from_mean = truth.colwise() - true_mean;
  // The alignment is the rotation nearest to this sum: of outer products of the
  // centres or, if they are nearly collinear, of each camera's rotation from
  // the found to the true world.
  const bool on_a_line = OnALine(from_mean) || OnALine(true_from_mean);
  const Matrix3d sum =
      on_a_line ? turns : Matrix3d(true_from_mean * from_mean.transpose());
  const Eigen::JacobiSVD<Matrix3d> svd(
      sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs = Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) {
    signs(2) = -1.0;
  }
  WorldAlignment alignment;
  alignment.R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  if (with_scale && from_mean.squaredNorm() > 0.0) {
    alignment.scale =
        (true_from_mean.cwiseProduct(alignment.R * from_mean)).sum() /
        from_mean.squaredNorm();
  }
  alignment.t = true_mean - alignment.scale * (alignment.R * found_mean);
  return alignment;
}

}  // namespace

CameraResult EvaluateCameras(const CameraRig& truth,
                             const std::string& truth_path,
                             const CameraRig& cameras,
                             const std::string& path) {
  CameraResult result;
  CameraPairs pairs;
  for (const Camera& expected : truth) {
    const auto same = std::find_if(
        cameras.begin(), cameras.end(),
        [&](const Camera& one) { return one.name() == expected.name(); });
    if (same != cameras.end()) {
      pairs.push_back({&expected, &*same});
    } else {
      result.missing.push_back(expected.name());
    }
  }
  if (pairs.size() < 2) {
    throw InputError(path, "",
                     "found " + std::to_string(pairs.size()) +
                         " cameras that are also in " + truth_path +
                         ", expected two or more");
  }
  const WorldAlignment rigid = Align(pairs, false);
  const WorldAlignment scaled = Align(pairs, true);
  result.scale = scaled.scale;
  Vector3d mean = Vector3d::Zero();
  const auto count = static_cast<double>(pairs.size());
  for (const auto& [expected, camera] : pairs) {
    mean += expected->centre() / count;
  }
  double size_m = 0.0;
  for (const auto& [expected, camera] : pairs) {
    size_m = std::max(size_m, (expected->centre() - mean).norm());
    CameraError& error = result.cameras.emplace_back();
    error.name = expected->name();
    error.position_m = (rigid * camera->centre() - expected->centre()).norm();
    error.scaled_position_m =
        (scaled * camera->centre() - expected->centre()).norm();
    error.rotation_deg =
        AngleDeg(camera->R() * rigid.R.transpose() * expected->R().transpose());
    result.te_m += error.position_m / count;
    result.scaled_te_m += error.scaled_position_m / count;
    result.ae_deg += error.rotation_deg / count;
  }
  result.rra.resize(result.rra_deg.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    for (size_t k = i + 1; k < pairs.size(); ++k) {
      const Matrix3d expected =
          pairs[i].first->R() * pairs[k].first->R().transpose();
      const Matrix3d found =
          pairs[i].second->R() * pairs[k].second->R().transpose();
      const double angle_deg = AngleDeg(expected * found.transpose());
      for (size_t r = 0; r < result.rra.size(); ++r) {
        result.rra[r].Add(angle_deg < result.rra_deg[r]);
      }
    }
  }
  result.cca.resize(result.cca_percent.size());
  result.scaled_cca.resize(result.cca_percent.size());
  for (const CameraError& error : result.cameras) {
    for (size_t r = 0; r < result.cca_percent.size(); ++r) {
      const double reach_m = 0.01 * result.cca_percent[r] * size_m;
      result.cca[r].Add(error.position_m < reach_m);
      result.scaled_cca[r].Add(error.scaled_position_m < reach_m);
    }
  }
  return result;
}

}  // namespace kinegraph
