// The arithmetic of the direct linear transformation over T: a double
// (triangulation.h, one point at a time) or a pack of doubles (dlt_lanes.h).
// Included by files that are compiled for one instruction set each, so it must
// not use Eigen.
#ifndef KINEGRAPH_CORE_GEOMETRY_DLT_KERNEL_H_
#define KINEGRAPH_CORE_GEOMETRY_DLT_KERNEL_H_

#include "core/base/pack.h"
#include "core/geometry/dlt_lanes.h"

namespace kinegraph {

// The rows of A, kept few by orthogonal reduction: |A X| depends on R of A = Q
// R alone. The normal matrix A^T A would square the condition number (Golub and
// Van Loan, Matrix Computations, section 5.3), which matters when a new view is
// combined with one two frames old: with the default lambda_t of 5 per frame,
// the weights are 1 and e^-10.
template <typename T>
class RowReducer {
 public:
  // Appends `weight` times the unit vector along (pixel p3 - p_axis); `P` is
  // 3x4 by columns. The row is zero unless the weight is positive.
  void Add(const double* P, const T& pixel, int axis, const T& weight) {
    if (rows_ == kCapacity) Reduce();
    T row[4];
    T norm_squared = 0.0;
    for (int k = 0; k < 4; ++k) {
      row[k] = pixel * P[3 * k + 2] - P[3 * k + axis];
      norm_squared += row[k] * row[k];
    }
    const T scale = weight / Sqrt(norm_squared);
    const Mask<T> counts = weight > T(0.0);
    for (int k = 0; k < 4; ++k) {
      columns_[k][rows_] = Select(counts, row[k] * scale, T(0.0));
    }
    ++rows_;
  }

  // Leaves the upper-triangular R in the first four rows (Householder).
  void Reduce() {
    for (; rows_ < 4; ++rows_) {
      for (auto& column : columns_) column[rows_] = 0.0;
    }
    for (int k = 0; k < 4; ++k) {
      T* pivot = columns_[k];
      T norm_squared = 0.0;
      for (int r = k; r < rows_; ++r) norm_squared += pivot[r] * pivot[r];
      const Mask<T> empty = norm_squared == T(0.0);
      const T norm = Sqrt(norm_squared);
      const T alpha = Select(pivot[k] > T(0.0), -norm, norm);
      // Reflector v = pivot - alpha e_k, v^T v = 2 (norm^2 - alpha pivot_k).
      // For a column of zeros it is scaled by zero and changes nothing.
      const T scale =
          Select(empty, T(0.0), 1.0 / (norm_squared - alpha * pivot[k]));
      pivot[k] -= alpha;
      for (int c = k + 1; c < 4; ++c) {
        T* column = columns_[c];
        T dot = 0.0;
        for (int r = k; r < rows_; ++r) dot += pivot[r] * column[r];
        dot *= scale;
        for (int r = k; r < rows_; ++r) column[r] -= dot * pivot[r];
      }
      pivot[k] = alpha;
      for (int r = k + 1; r < rows_; ++r) pivot[r] = 0.0;
    }
    rows_ = 4;
  }

  const T& R(int row, int col) const { return columns_[col][row]; }

 private:
  static constexpr int kCapacity = 32;
  T columns_[4][kCapacity];
  int rows_ = 0;
};

// Right singular vector of the smallest singular value of the upper-triangular
// R, which is the dominant eigenvector of G = (R^T R)^-1 = S S^T. Squares G,
// scaled to trace 1, until it has rank one, G = x x^T. Each squaring doubles
// the number of correct digits; with pixel noise two or three suffice. Where R
// is singular or its two smallest singular values are nearly equal, the mask is
// false and the vector zero.
template <typename T>
Mask<T> SmallestSingularVector(const RowReducer<T>& rows, T vector[4]) {
  T S[4][4];  // R^-1, upper triangular
  T largest = 0.0;
  for (int k = 0; k < 4; ++k) largest = Max(Abs(rows.R(k, k)), largest);
  Mask<T> regular = largest > T(0.0);
  for (int c = 0; c < 4; ++c) {
    regular = And(regular, Abs(rows.R(c, c)) > 1e-15 * largest);
    S[c][c] = 1.0 / rows.R(c, c);
    for (int r = c - 1; r >= 0; --r) {
      T sum = 0.0;
      for (int k = r + 1; k <= c; ++k) sum += rows.R(r, k) * S[k][c];
      S[r][c] = -sum * S[r][r];
    }
  }
  T G[4][4];
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c <= r; ++c) {
      T sum = S[r][r] * S[c][r];
      for (int k = r + 1; k < 4; ++k) sum += S[r][k] * S[c][k];
      G[r][c] = sum;
      G[c][r] = sum;
    }
  }
  constexpr int kMaxSquarings = 7;
  Mask<T> settled = T(0.0) > T(0.0);  // no lane yet
  for (int k = 0; k < 4; ++k) vector[k] = 0.0;
  for (int squaring = 0; squaring < kMaxSquarings; ++squaring) {
    const T inverse_trace = 1.0 / ((G[0][0] + G[1][1]) + (G[2][2] + G[3][3]));
    for (auto& row : G) {
      for (T& value : row) value *= inverse_trace;
    }
    // Squared Frobenius norm: even and odd rows separately, columns in pairs.
    T pairs[2];
    for (int odd = 0; odd < 2; ++odd) {
      T columns[4];
      for (int c = 0; c < 4; ++c) {
        columns[c] = G[odd][c] * G[odd][c] + G[odd + 2][c] * G[odd + 2][c];
      }
      pairs[odd] = (columns[0] + columns[1]) + (columns[2] + columns[3]);
    }
    // Trace minus norm is the share of the other eigenvalues; 1e-15 leaves an
    // error of that size in the direction.
    const T others = 1.0 - Sqrt(pairs[0] + pairs[1]);
    const Mask<T> now = And(And(regular, others < T(1e-15)), Not(settled));
    if (Any(now)) {
      // The column of the largest diagonal entry, normalised.
      T best = G[0][0];
      T column[4] = {G[0][0], G[1][0], G[2][0], G[3][0]};
      for (int c = 1; c < 4; ++c) {
        const Mask<T> larger = G[c][c] > best;
        best = Select(larger, G[c][c], best);
        for (int k = 0; k < 4; ++k) {
          column[k] = Select(larger, G[k][c], column[k]);
        }
      }
      const T norm = Sqrt((column[0] * column[0] + column[2] * column[2]) +
                          (column[1] * column[1] + column[3] * column[3]));
      for (int k = 0; k < 4; ++k) {
        vector[k] = Select(now, column[k] / norm, vector[k]);
      }
      settled = Or(settled, now);
      if (All(Or(settled, Not(regular)))) break;
    }
    T square[4][4];
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) {
        square[r][c] = G[r][0] * G[0][c];
        for (int k = 1; k < 4; ++k) square[r][c] += G[r][k] * G[k][c];
      }
    }
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) G[r][c] = square[r][c];
    }
  }
  return settled;
}

// Three terms in the order in which Eigen sums them.
template <typename T>
T Dot3(const T a[3], const T b[3]) {
  return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]);
}

// Whether the angle between any two rays to a point exceeds the minimum. Each
// ray is compared only with the first, so two rays up to twice the minimum
// apart may be missed.
template <typename T>
class ParallaxTest {
 public:
  explicit ParallaxTest(double min_angle_rad)
      : limit_(min_angle_rad * min_angle_rad) {}

  // Adds the ray from a camera's centre in the lanes in which the camera
  // counts.
  void Add(const double centre[3], const T point[3], const Mask<T>& counts) {
    T ray[3];
    for (int i = 0; i < 3; ++i) ray[i] = point[i] - centre[i];
    const T dot = Dot3(first_, ray);
    const T lengths = Dot3(first_, first_) * Dot3(ray, ray);
    // |a x b|^2 = |a|^2 |b|^2 - (a b)^2
    const Mask<T> differs =
        lengths - dot * dot > limit_ * Dot3(first_, first_) * Dot3(ray, ray);
    passed_ = Or(passed_, And(And(begun_, counts), differs));
    const Mask<T> is_first = And(counts, Not(begun_));
    for (int i = 0; i < 3; ++i) first_[i] = Select(is_first, ray[i], first_[i]);
    begun_ = Or(begun_, counts);
  }
  const Mask<T>& passed() const { return passed_; }

 private:
  const double limit_;
  T first_[3] = {T(0.0), T(0.0), T(0.0)};
  Mask<T> begun_ = T(0.0) > T(0.0);  // no lane yet
  Mask<T> passed_ = begun_;
};

template <typename T>
void TriangulateLanesWith(const LaneView* views, int view_count, int lanes,
                          const TriangulationOptions& options,
                          const LanePoints& points) {
  for (int lane = 0; lane < lanes; lane += T::kLanes) {
    RowReducer<T> rows;
    T used = 0.0;
    for (int i = 0; i < view_count; ++i) {
      const LaneView& view = views[i];
      const T weight = view.weight * T::Load(view.present + lane);
      used += Select(weight > T(0.0), T(1.0), T(0.0));
      rows.Add(view.P, T::Load(view.x_px + lane), 0, weight);
      rows.Add(view.P, T::Load(view.y_px + lane), 1, weight);
    }
    const Mask<T> enough = used >= T(2.0);
    T found = 0.0;
    T point[3] = {T(0.0), T(0.0), T(0.0)};
    if (Any(enough)) {
      rows.Reduce();
      T homogeneous[4];
      const Mask<T> settled = SmallestSingularVector(rows, homogeneous);
      for (int i = 0; i < 3; ++i) point[i] = homogeneous[i] / homogeneous[3];
      ParallaxTest<T> parallax(options.min_angle_rad);
      for (int i = 0; i < view_count; ++i) {
        const LaneView& view = views[i];
        parallax.Add(view.centre, point,
                     view.weight * T::Load(view.present + lane) > T(0.0));
      }
      Mask<T> good = parallax.passed();
      for (const T& coordinate : point) {
        good = And(good, Abs(coordinate) < T(1e300));  // finite
      }
      if (options.require_in_front) {
        for (int i = 0; i < view_count; ++i) {
          const LaneView& view = views[i];
          // K ends in [0 0 1]: the last row of P is the optical axis.
          const double* P = view.P;
          const T axis[3] = {T(P[2]), T(P[5]), T(P[8])};
          const T depth = Dot3(axis, point) + P[11];
          const Mask<T> counts =
              view.weight * T::Load(view.present + lane) > T(0.0);
          good = And(good, Or(Not(counts), depth > T(0.0)));
        }
      }
      found = Select(good, T(1.0), T(0.0));
      found = Select(settled, found, T(-1.0));
      found = Select(enough, found, T(0.0));
    }
    point[0].Store(points.x_m + lane);
    point[1].Store(points.y_m + lane);
    point[2].Store(points.z_m + lane);
    found.Store(points.found + lane);
  }
}

// The parts of the distance between two ideal pixels and each other's epipolar
// lines: |x_b' F x_a|, and the squared lengths of the lines' normals. F by
// columns.
template <typename T>
struct EpipolarTerms {
  KINEGRAPH_INLINE EpipolarTerms(const double* f, const T& ax, const T& ay,
                                 const T& bx, const T& by) {
    // Line of a in view b: F x_a; line of b in view a: F' x_b.
    const T in_b_x = f[0] * ax + f[3] * ay + f[6];
    const T in_b_y = f[1] * ax + f[4] * ay + f[7];
    const T in_b_z = f[2] * ax + f[5] * ay + f[8];
    const T in_a_x = f[0] * bx + f[1] * by + f[2];
    const T in_a_y = f[3] * bx + f[4] * by + f[5];
    residual = Abs(bx * in_b_x + by * in_b_y + in_b_z);
    norm_b = in_b_x * in_b_x + in_b_y * in_b_y;
    norm_a = in_a_x * in_a_x + in_a_y * in_a_y;
  }

  T residual, norm_a, norm_b;
};

// Implements MarkConflicts; the distance is EpipolarGeometry::Distance.
template <typename T>
void MarkConflictsWith(const LaneView& a, const LaneView& b, const double* f,
                       double alpha_px, int lanes, double* conflict) {
  for (int lane = 0; lane < lanes; lane += T::kLanes) {
    const Mask<T> both = And(T::Load(a.present + lane) > T(0.0),
                             T::Load(b.present + lane) > T(0.0));
    const EpipolarTerms<T> terms(f, T::Load(a.x_px + lane),
                                 T::Load(a.y_px + lane), T::Load(b.x_px + lane),
                                 T::Load(b.y_px + lane));
    const T length_a = Sqrt(terms.norm_a);
    const T length_b = Sqrt(terms.norm_b);
    const T distance =
        0.5 * terms.residual * (length_b + length_a) / (length_a * length_b);
    // At an epipole the distance is undefined, which is no conflict.
    const Mask<T> defined = And(terms.norm_a > T(0.0), terms.norm_b > T(0.0));
    const Mask<T> apart = 1.0 - distance / alpha_px < T(0.0);
    const T marked = Select(And(And(both, defined), apart), T(1.0),
                            T::Load(conflict + lane));
    marked.Store(conflict + lane);
  }
}

// One set of entry points per instruction set; only dlt_lanes.cc calls them.
#define KINEGRAPH_DLT_LANES(Set)                                               \
  void TriangulateLanes##Set(const LaneView* views, int view_count, int lanes, \
                             const TriangulationOptions& options,              \
                             const LanePoints& points);                        \
  void MarkConflicts##Set(const LaneView& a, const LaneView& b,                \
                          const double* fundamental, double alpha_px,          \
                          int lanes, double* conflict);
KINEGRAPH_DLT_LANES(Avx2)
KINEGRAPH_DLT_LANES(Avx512)
#undef KINEGRAPH_DLT_LANES

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_DLT_KERNEL_H_
