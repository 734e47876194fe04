// Symmetric 6x6 blocks of position and velocity over packs, by 3x3 parts.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_LANE_BLOCKS_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_LANE_BLOCKS_H_

#include "core/base/pack.h"

namespace kinegraph {

// [pp pv; pv' vv]. Symmetric parts as xx xy xz yy yz zz, pv by rows.
template <typename T>
struct LaneBlock {
  T pp[6];
  T pv[9];
  T vv[6];
};

inline constexpr int kLaneBlockSize = 21;  // in numbers

// Calls visit(i, entry i of each block) for i = 0 .. kLaneBlockSize - 1.
template <typename Visit, typename... Blocks>
KINEGRAPH_INLINE void ForEachEntry(const Visit &visit, Blocks &...blocks) {
  for (int i = 0; i < 6; ++i) visit(i, blocks.pp[i]...);
  for (int i = 0; i < 9; ++i) visit(6 + i, blocks.pv[i]...);
  for (int i = 0; i < 6; ++i) visit(15 + i, blocks.vv[i]...);
}

// A mask that is true in all lanes.
template <typename T>
KINEGRAPH_INLINE Mask<T> InAllLanes() {
  return T(0.0) < T(1.0);
}

// Place of (row, column) in a symmetric 3x3 part.
inline constexpr int kSymmetric[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

// 6x6 matrix of four 3x3 blocks: block (i, k) is a[i][k] times the identity.
template <typename T>
struct LaneAxis {
  T a[2][2];
};

// y -= m x
template <typename T>
KINEGRAPH_INLINE void SubtractProduct(const LaneAxis<T> &m, const T x[6],
                                      T y[6]) {
  for (int i = 0; i < 3; ++i) {
    y[i] -= m.a[0][0] * x[i] + m.a[0][1] * x[3 + i];
    y[3 + i] -= m.a[1][0] * x[i] + m.a[1][1] * x[3 + i];
  }
}

// y = m' x
template <typename T>
KINEGRAPH_INLINE void MultiplyTransposed(const LaneAxis<T> &m, const T x[6],
                                         T y[6]) {
  for (int i = 0; i < 3; ++i) {
    y[i] = m.a[0][0] * x[i] + m.a[1][0] * x[3 + i];
    y[3 + i] = m.a[0][1] * x[i] + m.a[1][1] * x[3 + i];
  }
}

// Multiplies the diagonal of s by `factor`.
template <typename T>
KINEGRAPH_INLINE void ScaleDiagonal(const T &factor, LaneBlock<T> *s) {
  for (int i = 0; i < 3; ++i) {
    s->pp[kSymmetric[i][i]] *= factor;
    s->vv[kSymmetric[i][i]] *= factor;
  }
}

// Inverse of a symmetric positive definite 3x3 by cofactors; the mask is true
// where it is positive definite.
template <typename T>
KINEGRAPH_INLINE Mask<T> Invert3(const T s[6], T inverse[6]) {
  const T xx = s[3] * s[5] - s[4] * s[4];
  const T xy = s[2] * s[4] - s[1] * s[5];
  const T xz = s[1] * s[4] - s[2] * s[3];
  const T zz = s[0] * s[3] - s[1] * s[1];
  const T determinant = s[0] * xx + s[1] * xy + s[2] * xz;
  const T scale = 1.0 / determinant;
  inverse[0] = xx * scale;
  inverse[1] = xy * scale;
  inverse[2] = xz * scale;
  inverse[3] = (s[0] * s[5] - s[2] * s[2]) * scale;
  inverse[4] = (s[1] * s[2] - s[0] * s[4]) * scale;
  inverse[5] = zz * scale;
  const T huge = 1e300;
  return And(And(s[0] > T(0.0), zz > T(0.0)),
             And(determinant > T(0.0), determinant < huge));
}

// Inverse of a symmetric positive definite block through its Schur complement.
template <typename T>
KINEGRAPH_INLINE Mask<T> Invert(const LaneBlock<T> &s, LaneBlock<T> *inverse) {
  T p[6];
  const Mask<T> first = Invert3(s.pp, p);
  T w[9];  // pp^-1 pv
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      w[3 * r + c] = p[kSymmetric[r][0]] * s.pv[c] +
                     p[kSymmetric[r][1]] * s.pv[3 + c] +
                     p[kSymmetric[r][2]] * s.pv[6 + c];
    }
  }
  T rest[6];  // vv - pv' pp^-1 pv
  for (int r = 0; r < 3; ++r) {
    for (int c = r; c < 3; ++c) {
      rest[kSymmetric[r][c]] =
          s.vv[kSymmetric[r][c]] -
          (s.pv[r] * w[c] + s.pv[3 + r] * w[3 + c] + s.pv[6 + r] * w[6 + c]);
    }
  }
  const Mask<T> second = Invert3(rest, inverse->vv);
  const T *v = inverse->vv;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      inverse->pv[3 * r + c] = -(w[3 * r] * v[kSymmetric[0][c]] +
                                 w[3 * r + 1] * v[kSymmetric[1][c]] +
                                 w[3 * r + 2] * v[kSymmetric[2][c]]);
    }
  }
  const T *x = inverse->pv;
  for (int r = 0; r < 3; ++r) {
    for (int c = r; c < 3; ++c) {
      inverse->pp[kSymmetric[r][c]] =
          p[kSymmetric[r][c]] -
          (x[3 * r] * w[3 * c] + x[3 * r + 1] * w[3 * c + 1] +
           x[3 * r + 2] * w[3 * c + 2]);
    }
  }
  return And(first, second);
}

// y = s x
template <typename T>
KINEGRAPH_INLINE void Multiply(const LaneBlock<T> &s, const T x[6], T y[6]) {
  for (int r = 0; r < 3; ++r) {
    y[r] = s.pp[kSymmetric[r][0]] * x[0] + s.pp[kSymmetric[r][1]] * x[1] +
           s.pp[kSymmetric[r][2]] * x[2] + s.pv[3 * r] * x[3] +
           s.pv[3 * r + 1] * x[4] + s.pv[3 * r + 2] * x[5];
    y[3 + r] = s.pv[r] * x[0] + s.pv[3 + r] * x[1] + s.pv[6 + r] * x[2] +
               s.vv[kSymmetric[r][0]] * x[3] + s.vv[kSymmetric[r][1]] * x[4] +
               s.vv[kSymmetric[r][2]] * x[5];
  }
}

// s -= m p m'
template <typename T>
KINEGRAPH_INLINE void SubtractCongruence(const LaneAxis<T> &m,
                                         const LaneBlock<T> &p,
                                         LaneBlock<T> *s) {
  const T m00 = m.a[0][0];
  const T m01 = m.a[0][1];
  const T m10 = m.a[1][0];
  const T m11 = m.a[1][1];
  const T pp_pp = m00 * m00;
  const T pp_pv = m00 * m01;
  const T pp_vv = m01 * m01;
  const T vv_pp = m10 * m10;
  const T vv_pv = m10 * m11;
  const T vv_vv = m11 * m11;
  const T pv_pp = m00 * m10;
  const T pv_pv = m00 * m11;
  const T pv_vp = m01 * m10;
  const T pv_vv = m01 * m11;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const int at = kSymmetric[r][c];
      if (r <= c) {
        const T both = p.pv[3 * r + c] + p.pv[3 * c + r];
        s->pp[at] -= pp_pp * p.pp[at] + pp_pv * both + pp_vv * p.vv[at];
        s->vv[at] -= vv_pp * p.pp[at] + vv_pv * both + vv_vv * p.vv[at];
      }
      s->pv[3 * r + c] -= pv_pp * p.pp[at] + pv_pv * p.pv[3 * r + c] +
                          pv_vp * p.pv[3 * c + r] + pv_vv * p.vv[at];
    }
  }
}

// Entry of the whole 6x6.
template <typename T>
KINEGRAPH_INLINE const T &Entry(const LaneBlock<T> &s, int row, int column) {
  if (row < 3 && column < 3) return s.pp[kSymmetric[row][column]];
  if (row >= 3 && column >= 3) return s.vv[kSymmetric[row - 3][column - 3]];
  return row < 3 ? s.pv[3 * row + column - 3] : s.pv[3 * column + row - 3];
}

// s += a' a for a 6x6 matrix a, stored column by column.
template <typename T>
KINEGRAPH_INLINE void AddSquareOf(const T *a, LaneBlock<T> *s) {
  const auto dot = [a](int i, int j) {
    T sum = a[6 * i] * a[6 * j];
    for (int row = 1; row < 6; ++row) sum += a[6 * i + row] * a[6 * j + row];
    return sum;
  };
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      if (r <= c) {
        s->pp[kSymmetric[r][c]] += dot(r, c);
        s->vv[kSymmetric[r][c]] += dot(3 + r, 3 + c);
      }
      s->pv[3 * r + c] += dot(r, 3 + c);
    }
  }
}

// s += g c g' with g = p m', a step of selected inversion.
template <typename T>
void AddGained(const LaneBlock<T> &p, const LaneAxis<T> &m,
               const LaneBlock<T> &c, LaneBlock<T> *s) {
  T gain[6][6];
  for (int row = 0; row < 6; ++row) {
    for (int i = 0; i < 3; ++i) {
      const T &by_p = Entry(p, row, i);
      const T &by_v = Entry(p, row, 3 + i);
      gain[row][i] = by_p * m.a[0][0] + by_v * m.a[0][1];
      gain[row][3 + i] = by_p * m.a[1][0] + by_v * m.a[1][1];
    }
  }
  T product[6][6];  // gain c
  for (int row = 0; row < 6; ++row) Multiply(c, gain[row], product[row]);
  const auto dot = [&](int i, int j) {
    T sum = product[i][0] * gain[j][0];
    for (int k = 1; k < 6; ++k) sum += product[i][k] * gain[j][k];
    return sum;
  };
  for (int r = 0; r < 3; ++r) {
    for (int column = 0; column < 3; ++column) {
      if (r <= column) {
        s->pp[kSymmetric[r][column]] += dot(r, column);
        s->vv[kSymmetric[r][column]] += dot(3 + r, 3 + column);
      }
      s->pv[3 * r + column] += dot(r, 3 + column);
    }
  }
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_LANE_BLOCKS_H_
