#include "solvers/filters/robust_triangulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/geometry/triangulation.h"
#include "solvers/factors/loss.h"

namespace kinegraph {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Lower triangle of a symmetric matrix, row by row.
using Lower = std::array<double, 6>;

// Cost and Gauss-Newton system at a point. A view in which the point has no
// image contributes the cost of `kUnseen` sigmas and no gradient.
struct Linearised {
  double cost = 0.0;
  Lower normal{};
  // With the loss's own curvature along each residual, kept positive: fewer
  // steps than with reweighting alone.
  Lower curvature{};
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  std::vector<double> weights;
};

void Linearise(LossKind loss, double scale,
               const std::vector<PixelPoint>& views,
               const Eigen::Vector3d& point_m, Linearised* at) {
  constexpr double kUnseen = 1e3;
  // Local sums stay in registers; symmetric matrices as lower triangles.
  double cost = 0.0;
  Lower normal{};
  Lower curvature{};
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  at->weights.clear();
  for (const PixelPoint& view : views) {
    Matrix23d J;
    const auto projected = view.camera->Project(point_m, &J);
    if (!projected.has_value()) {
      cost += 0.5 * EvaluateLoss(loss, scale, kUnseen * kUnseen).rho;
      at->weights.push_back(0.0);
      continue;
    }
    const Eigen::Vector2d residual = (*projected - view.px) / view.sigma_px;
    J /= view.sigma_px;
    const LossValue value = EvaluateLoss(loss, scale, residual.squaredNorm());
    cost += 0.5 * value.rho;
    const Eigen::Vector3d pull = J.transpose() * residual;
    // Least curvature along the residual, as a fraction of the weight.
    constexpr double kLeast = 0.1;
    const double bend = std::max(
        2.0 * value.second,
        (kLeast - 1.0) * value.first / std::max(residual.squaredNorm(), 1e-12));
    for (int i = 0, n = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j, ++n) {
        const double square =
            value.first * J(0, i) * J(0, j) + value.first * J(1, i) * J(1, j);
        normal[n] += square;
        curvature[n] += square + bend * pull[i] * pull[j];
      }
    }
    gradient += value.first * pull;
    at->weights.push_back(value.first);
  }
  at->cost = cost;
  at->normal = normal;
  at->curvature = curvature;
  at->gradient = gradient;
}

// Inverts a positive definite matrix by L D L'. False if it is not positive
// definite, or its pivots differ by more than rounding permits.
bool Invert(const Lower& lower, Eigen::Matrix3d* inverse) {
  const double d0 = lower[0];
  const double l10 = lower[1] / d0;
  const double l20 = lower[3] / d0;
  const double d1 = lower[2] - l10 * lower[1];
  const double low = lower[4] - l10 * lower[3];
  const double l21 = low / d1;
  const double d2 = lower[5] - l20 * lower[3] - l21 * low;
  const double least = std::min({d0, d1, d2});
  if (!(least > 0.0) || !(least > 1e-12 * std::max({d0, d1, d2}))) return false;
  // The inverse of L is unit lower triangular too.
  const double m20 = l10 * l21 - l20;
  const double i0 = 1.0 / d0;
  const double i1 = 1.0 / d1;
  const double i2 = 1.0 / d2;
  const double xy = -l10 * i1 - m20 * l21 * i2;
  const double xz = m20 * i2;
  const double yz = -l21 * i2;
  *inverse << i0 + l10 * l10 * i1 + m20 * m20 * i2, xy, xz,  //
      xy, i1 + l21 * l21 * i2, yz,                           //
      xz, yz, i2;
  return inverse->allFinite();
}

// The start of lowest cost: the DLT of all views or of a pair. False if there
// is none.
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
  Linearised there;
  const auto consider = [&](Span<PointMeasurement> measurements) {
    const TriangulationResult result = TriangulateDlt(measurements);
    if (!result.ok()) return;
    Linearise(options.loss, options.loss_scale, views, result.point_m, &there);
    if (!(there.cost < least)) return;
    least = there.cost;
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
  constexpr int kMaxHalvings = 8;
  Linearised here;
  Linearised there;
  Linearise(options_.loss, options_.loss_scale, views, point.position_m, &here);
  Eigen::Matrix3d inverse;
  for (int i = 0; i < kMaxIterations; ++i) {
    if (!Invert(here.curvature, &inverse)) return std::nullopt;
    Eigen::Vector3d step_m = -inverse * here.gradient;
    int halvings = 0;
    for (; halvings <= kMaxHalvings; ++halvings, step_m *= 0.5) {
      Linearise(options_.loss, options_.loss_scale, views,
                point.position_m + step_m, &there);
      if (there.cost <= here.cost) break;
    }
    if (halvings > kMaxHalvings) break;  // as low as rounding permits
    point.position_m += step_m;
    std::swap(here, there);
    if (step_m.norm() < options_.last_step_m) break;
  }
  if (!point.position_m.allFinite() || !Invert(here.normal, &inverse)) {
    return std::nullopt;
  }
  point.inlier_views = static_cast<int>(
      std::count_if(here.weights.begin(), here.weights.end(),
                    [](double weight) { return weight >= kInlierWeight; }));
  if (point.inlier_views < 2) return std::nullopt;
  point.covariance_m2 = inverse;
  point.weights = std::move(here.weights);
  return point;
}

std::optional<Eigen::Matrix3d> TriangulationCovariance(
    const std::vector<PixelPoint>& views, const Eigen::Vector3d& point_m) {
  Eigen::Matrix3d covariance;
  Linearised here;
  Linearise(LossKind::kNone, 1.0, views, point_m, &here);
  if (!Invert(here.normal, &covariance)) return std::nullopt;
  return covariance;
}

}  // namespace kinegraph
