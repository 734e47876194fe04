#include "solvers/filters/robust_triangulation.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "core/geometry/triangulation.h"

namespace kinegraph {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Cost and Gauss-Newton system at a point. A view that cannot see the point
// costs as if it were `kUnseen` sigmas off and pulls nowhere.
struct Linearised {
  double cost = 0.0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  std::vector<double> weights;
};

Linearised Linearise(LossKind loss, double scale,
                     const std::vector<PixelPoint>& views,
                     const Eigen::Vector3d& point_m) {
  constexpr double kUnseen = 1e3;
  Linearised result;
  result.weights.reserve(views.size());
  for (const PixelPoint& view : views) {
    Matrix23d J;
    const auto projected = view.camera->Project(point_m, &J);
    if (!projected.has_value()) {
      result.cost += 0.5 * EvaluateLoss(loss, scale, kUnseen * kUnseen).rho;
      result.weights.push_back(0.0);
      continue;
    }
    const Eigen::Vector2d residual = (*projected - view.px) / view.sigma_px;
    J /= view.sigma_px;
    const LossValue value = EvaluateLoss(loss, scale, residual.squaredNorm());
    result.cost += 0.5 * value.rho;
    result.normal += value.first * J.transpose() * J;
    result.gradient += value.first * J.transpose() * residual;
    result.weights.push_back(value.first);
  }
  return result;
}

bool Invert(const Eigen::Matrix3d& matrix, Eigen::Matrix3d* inverse) {
  const Eigen::LDLT<Eigen::Matrix3d> factor(matrix);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return false;
  const Eigen::Vector3d d = factor.vectorD();
  if (!(d.minCoeff() > 1e-12 * d.maxCoeff())) return false;
  *inverse = factor.solve(Eigen::Matrix3d::Identity());
  return inverse->allFinite();
}

// The cheapest start.
bool FindStart(const RobustTriangulationOptions& options,
               const std::vector<PixelPoint>& views, Eigen::Vector3d* start) {
  std::vector<PointMeasurement> ideal;
  for (const PixelPoint& view : views) {
    const auto undistorted = view.camera->Undistort(view.px);
    if (undistorted.has_value()) {
      ideal.push_back({view.camera, *undistorted, 1.0 / view.sigma_px});
    }
  }
  double least = kInfinity;
  const auto consider = [&](Span<PointMeasurement> measurements) {
    const TriangulationResult result = TriangulateDlt(measurements);
    if (!result.ok()) return;
    const double cost =
        Linearise(options.loss, options.loss_scale, views, result.point_m).cost;
    if (!(cost < least)) return;
    least = cost;
    *start = result.point_m;
  };
  if (ideal.size() < 2) return false;
  consider(ideal);
  for (size_t a = 0; ideal.size() > 2 && a < ideal.size(); ++a) {
    for (size_t b = a + 1; b < ideal.size(); ++b) {
      consider(std::vector<PointMeasurement>{ideal[a], ideal[b]});
    }
  }
  return least < kInfinity;
}

}  // namespace

void RobustTriangulationOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("loss", &loss, LossNames(), "of the reprojections");
  visitor.Number("loss_scale", &loss_scale, Positive(), "sigmas",
                 "where the loss starts to doubt a view");
  visitor.Number("inlier_weight", &inlier_weight, Between(0.0, 1.0), "",
                 "weight from which a view supports the point");
}

RobustTriangulator::RobustTriangulator(
    const RobustTriangulationOptions& options)
    : options_(options) {
  CheckOptions(options);
}

std::optional<RobustPoint> RobustTriangulator::Triangulate(
    const std::vector<PixelPoint>& views) const {
  Eigen::Vector3d start_m;
  if (!FindStart(options_, views, &start_m)) return std::nullopt;
  return TriangulateFrom(start_m, views);
}

std::optional<RobustPoint> RobustTriangulator::TriangulateFrom(
    const Eigen::Vector3d& start_m,
    const std::vector<PixelPoint>& views) const {
  RobustPoint point;
  point.position_m = start_m;
  constexpr int kMaxIterations = 30;
  constexpr double kStep_m = 1e-7;
  constexpr int kMaxHalvings = 8;
  Linearised here =
      Linearise(options_.loss, options_.loss_scale, views, point.position_m);
  Eigen::Matrix3d inverse;
  for (int i = 0; i < kMaxIterations; ++i) {
    if (!Invert(here.normal, &inverse)) return std::nullopt;
    Eigen::Vector3d step_m = -inverse * here.gradient;
    Linearised there;
    int halvings = 0;
    for (; halvings <= kMaxHalvings; ++halvings, step_m *= 0.5) {
      there = Linearise(options_.loss, options_.loss_scale, views,
                        point.position_m + step_m);
      if (there.cost <= here.cost) break;
    }
    if (halvings > kMaxHalvings) break;  // as low as rounding allows
    point.position_m += step_m;
    here = std::move(there);
    if (step_m.norm() < kStep_m) break;
  }
  if (!point.position_m.allFinite() || !Invert(here.normal, &inverse)) {
    return std::nullopt;
  }
  for (const double weight : here.weights) {
    if (weight >= options_.inlier_weight) ++point.inlier_views;
  }
  if (point.inlier_views < 2) return std::nullopt;
  point.covariance_m2 = inverse;
  point.weights = std::move(here.weights);
  return point;
}

std::optional<Eigen::Matrix3d> TriangulationCovariance(
    const std::vector<PixelPoint>& views, const Eigen::Vector3d& point_m) {
  Eigen::Matrix3d covariance;
  const Linearised here = Linearise(LossKind::kNone, 1.0, views, point_m);
  if (!Invert(here.normal, &covariance)) return std::nullopt;
  return covariance;
}

}  // namespace kinegraph
