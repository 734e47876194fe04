#include "core/geometry/triangulation.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

// The rows of A, kept small by orthogonal reduction: |A X| depends on R of
// A = Q R alone. The normal matrix would square the condition, and a point seen
// by one new view and one three frames old has weights 1 and e^-15.
class RowReducer {
 public:
  // Appends `weight` times the unit vector along (pixel p3 - p_axis).
  void Add(const Matrix34d& P, double pixel, int axis, double weight) {
    if (rows_ == kCapacity) Reduce();
    double row[4];
    double norm_squared = 0.0;
    for (int k = 0; k < 4; ++k) {
      row[k] = pixel * P(2, k) - P(axis, k);
      norm_squared += row[k] * row[k];
    }
    const double scale = weight / std::sqrt(norm_squared);
    for (int k = 0; k < 4; ++k) columns_[k][rows_] = row[k] * scale;
    ++rows_;
  }

  // Leaves the upper-triangular R in the first four rows (Householder).
  void Reduce() {
    for (; rows_ < 4; ++rows_) {
      for (auto& column : columns_) column[rows_] = 0.0;
    }
    for (int k = 0; k < 4; ++k) {
      double* pivot = columns_[k];
      double norm_squared = 0.0;
      for (int r = k; r < rows_; ++r) norm_squared += pivot[r] * pivot[r];
      if (norm_squared == 0.0) continue;
      const double norm = std::sqrt(norm_squared);
      const double alpha = pivot[k] > 0.0 ? -norm : norm;
      // Reflector v = pivot - alpha e_k; v^T v = 2 (norm^2 - alpha pivot_k).
      const double scale = 1.0 / (norm_squared - alpha * pivot[k]);
      pivot[k] -= alpha;
      for (int c = k + 1; c < 4; ++c) {
        double* column = columns_[c];
        double dot = 0.0;
        for (int r = k; r < rows_; ++r) dot += pivot[r] * column[r];
        dot *= scale;
        for (int r = k; r < rows_; ++r) column[r] -= dot * pivot[r];
      }
      pivot[k] = alpha;
      for (int r = k + 1; r < rows_; ++r) pivot[r] = 0.0;
    }
    rows_ = 4;
  }

  double R(int row, int col) const { return columns_[col][row]; }

 private:
  static constexpr int kCapacity = 32;
  double columns_[4][kCapacity];
  int rows_ = 0;
};

// Right singular vector of the smallest singular value of upper-triangular R:
// the dominant eigenvector of G = (R^T R)^-1, by squaring G until it has rank
// one. Each squaring doubles the digits; noise gives two or three. Returns
// false when the two smallest singular values are nearly equal, or R is
// singular.
bool SmallestSingularVector(const RowReducer& rows, Eigen::Vector4d* vector) {
  // S = R^-1, upper triangular.
  Eigen::Matrix4d S = Eigen::Matrix4d::Zero();
  double largest = 0.0;
  for (int k = 0; k < 4; ++k) {
    largest = std::max(largest, std::abs(rows.R(k, k)));
  }
  for (int c = 0; c < 4; ++c) {
    if (!(std::abs(rows.R(c, c)) > 1e-15 * largest)) return false;
    S(c, c) = 1.0 / rows.R(c, c);
    for (int r = c - 1; r >= 0; --r) {
      double sum = 0.0;
      for (int k = r + 1; k <= c; ++k) sum += rows.R(r, k) * S(k, c);
      S(r, c) = -sum * S(r, r);
    }
  }
  Eigen::Matrix4d G;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c <= r; ++c) {
      double sum = 0.0;
      for (int k = r; k < 4; ++k) sum += S(r, k) * S(c, k);
      G(r, c) = sum;
      G(c, r) = sum;
    }
  }
  constexpr int kMaxSquarings = 7;
  for (int squaring = 0; squaring < kMaxSquarings; ++squaring) {
    G *= 1.0 / G.trace();
    // trace - Frobenius norm is the share of the other eigenvalues: 1e-15 of it
    // leaves an error of the same size in the direction.
    const double others = 1.0 - std::sqrt(G.squaredNorm());
    if (!std::isfinite(others)) return false;
    const bool settled = others < 1e-15;
    if (settled) {
      Eigen::Index column = 0;
      G.diagonal().maxCoeff(&column);
      *vector = G.col(column).normalized();
      return true;
    }
    G = (G * G).eval();
  }
  return false;
}

Eigen::Vector4d Solve(RowReducer* rows) {
  rows->Reduce();
  Eigen::Vector4d vector;
  if (SmallestSingularVector(*rows, &vector)) return vector;
  Eigen::Matrix4d R = Eigen::Matrix4d::Zero();
  for (int r = 0; r < 4; ++r) {
    for (int c = r; c < 4; ++c) R(r, c) = rows->R(r, c);
  }
  const Eigen::JacobiSVD<Eigen::Matrix4d> svd(R, Eigen::ComputeFullV);
  return svd.matrixV().col(3);
}

// Whether two rays from the cameras to the point differ by the least angle. At
// least one measurement has a positive weight.
bool HasParallax(Span<PointMeasurement> measurements,
                 const Eigen::Vector3d& point, double min_angle_rad) {
  // An angle to the first ray is enough: if all are below half of the least
  // angle, no two reach it; between half and whole the answer errs by at most
  // a factor of two, which a threshold of this kind can bear.
  // Measurements without weight did not make the point and say nothing of it.
  size_t i = 0;
  while (!(measurements[i].weight > 0.0)) ++i;
  const Eigen::Vector3d first = point - measurements[i].camera->centre();
  const double sin_squared_limit = min_angle_rad * min_angle_rad;
  for (++i; i < measurements.size(); ++i) {
    if (!(measurements[i].weight > 0.0)) continue;
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
                                   const TriangulationOptions& options) {
  TriangulationResult result;
  RowReducer rows;
  int used = 0;
  for (const PointMeasurement& m : measurements) {
    if (!std::isfinite(m.ideal_px.x()) || !std::isfinite(m.ideal_px.y()) ||
        !std::isfinite(m.weight)) {
      result.status = TriangulationStatus::kNotFinite;
      return result;
    }
    if (!(m.weight > 0.0)) continue;
    ++used;
    rows.Add(m.camera->P(), m.ideal_px.x(), 0, m.weight);
    rows.Add(m.camera->P(), m.ideal_px.y(), 1, m.weight);
  }
  if (used < 2) return result;
  const Eigen::Vector4d homogeneous = Solve(&rows);
  result.point_m = homogeneous.head<3>() / homogeneous(3);
  if (!result.point_m.allFinite()) {
    // A direction, not a point: the rays meet at infinity.
    result.status = homogeneous.allFinite() ? TriangulationStatus::kParallelRays
                                            : TriangulationStatus::kNotFinite;
    return result;
  }
  if (!HasParallax(measurements, result.point_m, options.min_angle_rad)) {
    result.status = TriangulationStatus::kParallelRays;
    return result;
  }
  for (const PointMeasurement& m : measurements) {
    if (!options.require_in_front) break;
    if (m.weight > 0.0 && !(m.camera->Depth(result.point_m) > 0.0)) {
      result.status = TriangulationStatus::kBehindCamera;
      return result;
    }
  }
  result.status = TriangulationStatus::kOk;
  return result;
}

}  // namespace kinegraph
