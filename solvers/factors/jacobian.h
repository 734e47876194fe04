// Jacobians of factors by a state [p; v], in types that exploit their zeros.
//
// T is double, or a pack of doubles where joints lie in lanes: any type with +
// - * /, and sqrt and max where a factor needs them. Uses no Eigen and does not
// allocate, so that files compiled for wider instruction sets may include it.
#ifndef KINEGRAPH_SOLVERS_FACTORS_JACOBIAN_H_
#define KINEGRAPH_SOLVERS_FACTORS_JACOBIAN_H_

namespace kinegraph {

// Position [m] and velocity [m/s] in the world, x y z each.
inline constexpr int kStateSize = 6;

// Position of the joint with `state` [6] at `offset_s` after the frame's time,
// extrapolated with constant velocity: accurate for offsets up to about a
// frame. Factors model clock offsets here only; PointJacobian is the
// derivative.
template <typename T>
void PointAt(const T* state, double offset_s, T* point) {
  for (int i = 0; i < 3; ++i) {
    point[i] = offset_s == 0.0 ? state[i] : state[i] + offset_s * state[i + 3];
  }
}

// Jacobian of kRows residuals that depend on the point at offset_s: [by_point,
// offset_s by_point], kRows x 6.
template <int kRowCount, typename T>
struct PointJacobian {
  static constexpr int kRows = kRowCount;
  T by_point[kRows][3];
  double offset_s = 0.0;

  T operator()(int row, int column) const {
    return column < 3 ? by_point[row][column]
                      : offset_s * by_point[row][column - 3];
  }
};

// Jacobian of six residuals that treat the three axes alike: axis, each entry
// times the 3x3 identity.
template <typename T>
struct AxisJacobian {
  static constexpr int kRows = kStateSize;
  T axis[2][2];

  T operator()(int row, int column) const {
    return row % 3 == column % 3 ? axis[row / 3][column / 3] : T(0.0);
  }
};

// Any Jacobian.
template <int kRowCount, typename T>
struct DenseJacobian {
  static constexpr int kRows = kRowCount;
  T by_state[kRows][kStateSize];

  T operator()(int row, int column) const { return by_state[row][column]; }
};

// block += weight a' b, 6x6, column by column.
template <int kRows, typename T>
void AddProduct(const PointJacobian<kRows, T>& a,
                const PointJacobian<kRows, T>& b, T weight, T* block) {
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      T sum = a.by_point[0][row] * b.by_point[0][column];
      for (int i = 1; i < kRows; ++i) {
        sum = sum + a.by_point[i][row] * b.by_point[i][column];
      }
      sum = weight * sum;
      T* at = block + kStateSize * column + row;
      at[0] = at[0] + sum;
      if (a.offset_s != 0.0) at[3] = at[3] + a.offset_s * sum;
      if (b.offset_s == 0.0) continue;
      at[3 * kStateSize] = at[3 * kStateSize] + b.offset_s * sum;
      at[3 * kStateSize + 3] =
          at[3 * kStateSize + 3] + a.offset_s * b.offset_s * sum;
    }
  }
}

template <typename T>
void AddProduct(const AxisJacobian<T>& a, const AxisJacobian<T>& b, T weight,
                T* block) {
  for (int column = 0; column < 2; ++column) {
    for (int row = 0; row < 2; ++row) {
      const T sum = weight * (a.axis[0][row] * b.axis[0][column] +
                              a.axis[1][row] * b.axis[1][column]);
      for (int i = 0; i < 3; ++i) {
        T* at = block + kStateSize * (3 * column + i) + 3 * row + i;
        *at = *at + sum;
      }
    }
  }
}

template <int kRows, typename T>
void AddProduct(const DenseJacobian<kRows, T>& a,
                const DenseJacobian<kRows, T>& b, T weight, T* block) {
  for (int column = 0; column < kStateSize; ++column) {
    for (int row = 0; row < kStateSize; ++row) {
      T sum = a.by_state[0][row] * b.by_state[0][column];
      for (int i = 1; i < kRows; ++i) {
        sum = sum + a.by_state[i][row] * b.by_state[i][column];
      }
      T* at = block + kStateSize * column + row;
      *at = *at + weight * sum;
    }
  }
}

// gradient += weight a' residual, 6.
template <int kRows, typename T>
void AddGradient(const PointJacobian<kRows, T>& a, const T* residual, T weight,
                 T* gradient) {
  for (int column = 0; column < 3; ++column) {
    T sum = a.by_point[0][column] * residual[0];
    for (int i = 1; i < kRows; ++i) {
      sum = sum + a.by_point[i][column] * residual[i];
    }
    sum = weight * sum;
    gradient[column] = gradient[column] + sum;
    if (a.offset_s == 0.0) continue;
    gradient[column + 3] = gradient[column + 3] + a.offset_s * sum;
  }
}

template <typename T>
void AddGradient(const AxisJacobian<T>& a, const T* residual, T weight,
                 T* gradient) {
  for (int column = 0; column < 2; ++column) {
    for (int i = 0; i < 3; ++i) {
      T* at = gradient + 3 * column + i;
      *at = *at + weight * (a.axis[0][column] * residual[i] +
                            a.axis[1][column] * residual[i + 3]);
    }
  }
}

template <int kRows, typename T>
void AddGradient(const DenseJacobian<kRows, T>& a, const T* residual, T weight,
                 T* gradient) {
  for (int column = 0; column < kStateSize; ++column) {
    T sum = a.by_state[0][column] * residual[0];
    for (int i = 1; i < kRows; ++i) {
      sum = sum + a.by_state[i][column] * residual[i];
    }
    gradient[column] = gradient[column] + weight * sum;
  }
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_JACOBIAN_H_
