#include "core/geometry/triangulation.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace kinegraph {
namespace {

// Eigenvector of the smallest eigenvalue of a symmetric positive semi-definite
// matrix, by inverse iteration: it gains a factor lambda_3 / lambda_4 in each
// step, usually a thousand, where the general solver takes ten times as long.
// Returns false when it does not settle (two nearly equal eigenvalues).
bool InverseIteration(const Eigen::Matrix4d& m, Eigen::Vector4d* eigenvector) {
  // Cholesky factor; the shift keeps it defined for exact measurements.
  const double shift = 1e-15 * m.trace();
  double l[4][4];
  double inverse_diagonal[4];
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c <= r; ++c) {
      double sum = m(r, c);
      if (r == c) sum += shift;
      for (int k = 0; k < c; ++k) sum -= l[r][k] * l[c][k];
      if (r == c) {
        if (!(sum > 0.0)) return false;
        l[r][r] = std::sqrt(sum);
        inverse_diagonal[r] = 1.0 / l[r][r];
      } else {
        l[r][c] = sum * inverse_diagonal[c];
      }
    }
  }
  // The last pivot belongs to the weakest direction, so the last row of the
  // inverse factor is a good start: solve L^T x = e4.
  double x[4] = {0.0, 0.0, 0.0, 1.0};
  for (int r = 2; r >= 0; --r) {
    double sum = 0.0;
    for (int k = r + 1; k < 4; ++k) sum -= l[k][r] * x[k];
    x[r] = sum * inverse_diagonal[r];
  }
  const auto normalise = [](double* v) {
    const double norm =
        std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
    const double scale = 1.0 / norm;
    for (int i = 0; i < 4; ++i) v[i] *= scale;
  };
  // With e4 the first three entries above were solved for L(4,4) = 1.
  normalise(x);
  constexpr int kMaxIterations = 12;
  constexpr double kSettled = 1e-26;  // squared change: 1e-13 of a unit vector
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    double y[4];
    for (int r = 0; r < 4; ++r) {
      double sum = x[r];
      for (int k = 0; k < r; ++k) sum -= l[r][k] * y[k];
      y[r] = sum * inverse_diagonal[r];
    }
    for (int r = 3; r >= 0; --r) {
      double sum = y[r];
      for (int k = r + 1; k < 4; ++k) sum -= l[k][r] * y[k];
      y[r] = sum * inverse_diagonal[r];
    }
    normalise(y);
    double change = 0.0;
    for (int i = 0; i < 4; ++i) {
      change += (y[i] - x[i]) * (y[i] - x[i]);
      x[i] = y[i];
    }
    if (!(change >= 0.0)) return false;
    if (change < kSettled) {
      *eigenvector << x[0], x[1], x[2], x[3];
      return true;
    }
  }
  return false;
}

Eigen::Vector4d SmallestEigenvector(const Eigen::Matrix4d& m) {
  Eigen::Vector4d eigenvector;
  if (InverseIteration(m, &eigenvector)) return eigenvector;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(m);
  return solver.eigenvectors().col(0);
}

// Adds the squared, weighted unit row (u p3 - p) to the normal matrix.
void AddRow(const Matrix34d& P, double pixel, int axis, double weight_squared,
            Eigen::Matrix4d* normal) {
  double row[4];
  double norm_squared = 0.0;
  for (int k = 0; k < 4; ++k) {
    row[k] = pixel * P(2, k) - P(axis, k);
    norm_squared += row[k] * row[k];
  }
  const double scale = weight_squared / norm_squared;
  for (int c = 0; c < 4; ++c) {
    const double scaled = row[c] * scale;
    for (int r = c; r < 4; ++r) (*normal)(r, c) += row[r] * scaled;
  }
}

// Whether two rays from the cameras to the point differ by the least angle.
bool HasParallax(Span<PointMeasurement> measurements,
                 const Eigen::Vector3d& point, double min_angle_rad) {
  // An angle to the first ray is enough: if all are below half of the least
  // angle, no two reach it; between half and whole the answer errs by at most
  // a factor of two, which a threshold of this kind can bear.
  const Eigen::Vector3d first = point - measurements[0].camera->centre();
  const double sin_squared_limit = min_angle_rad * min_angle_rad;
  for (size_t i = 1; i < measurements.size(); ++i) {
    const Eigen::Vector3d other = point - measurements[i].camera->centre();
    const double cross_squared = first.squaredNorm() * other.squaredNorm() -
                                 first.dot(other) * first.dot(other);
    if (cross_squared >
        sin_squared_limit * first.squaredNorm() * other.squaredNorm()) {
      return true;
    }
  }
  return false;
}

}  // namespace

const char* ToString(TriangulationStatus status) {
  switch (status) {
    case TriangulationStatus::kOk:
      return "ok";
    case TriangulationStatus::kTooFewViews:
      return "too few views";
    case TriangulationStatus::kNotFinite:
      return "not finite";
    case TriangulationStatus::kParallelRays:
      return "parallel rays";
    case TriangulationStatus::kBehindCamera:
      break;
  }
  return "behind a camera";
}

TriangulationResult TriangulateDlt(Span<PointMeasurement> measurements,
                                   double min_angle_rad) {
  TriangulationResult result;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  int used = 0;
  for (const PointMeasurement& m : measurements) {
    if (!std::isfinite(m.ideal_px.x()) || !std::isfinite(m.ideal_px.y()) ||
        !std::isfinite(m.weight)) {
      result.status = TriangulationStatus::kNotFinite;
      return result;
    }
    if (!(m.weight > 0.0)) continue;
    ++used;
    const double weight_squared = m.weight * m.weight;
    AddRow(m.camera->P(), m.ideal_px.x(), 0, weight_squared, &normal);
    AddRow(m.camera->P(), m.ideal_px.y(), 1, weight_squared, &normal);
  }
  if (used < 2) return result;
  normal.triangularView<Eigen::StrictlyUpper>() =
      normal.transpose().triangularView<Eigen::StrictlyUpper>();
  const Eigen::Vector4d homogeneous = SmallestEigenvector(normal);
  result.point_m = homogeneous.head<3>() / homogeneous(3);
  if (!result.point_m.allFinite()) {
    // A direction, not a point: the rays meet at infinity.
    result.status = homogeneous.allFinite() ? TriangulationStatus::kParallelRays
                                            : TriangulationStatus::kNotFinite;
    return result;
  }
  if (!HasParallax(measurements, result.point_m, min_angle_rad)) {
    result.status = TriangulationStatus::kParallelRays;
    return result;
  }
  for (const PointMeasurement& m : measurements) {
    if (m.weight > 0.0 && !(m.camera->Depth(result.point_m) > 0.0)) {
      result.status = TriangulationStatus::kBehindCamera;
      return result;
    }
  }
  result.status = TriangulationStatus::kOk;
  return result;
}

}  // namespace kinegraph
