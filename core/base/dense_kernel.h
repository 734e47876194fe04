// The arithmetic of EliminateDense (dense_lanes.h) over a SIMD type (pack.h).
// Included by files that are compiled for one instruction set each, so it must
// not use Eigen.
//
// The factorisation is left-looking, in panels of four columns: while a tile of
// the panel's rows stays in registers, earlier columns are subtracted from it
// and the triangular system of the panel's corner, its 4 x 4 block on the
// diagonal, is solved. Rows lie in lanes; sums run over columns in order, so
// the bits do not depend on the number of lanes.
#ifndef KINEGRAPH_CORE_BASE_DENSE_KERNEL_H_
#define KINEGRAPH_CORE_BASE_DENSE_KERNEL_H_

#include "core/base/dense_lanes.h"
#include "core/base/pack.h"

namespace kinegraph {

template <typename T>
class DenseEliminator {
 public:
  explicit DenseEliminator(const DenseElimination& blocks)
      : blocks_(blocks), size_(blocks.size) {}

  bool Run() {
    for (int column = 0; column < size_; column += kPanel) {
      if (!FactorCorner(column)) return false;
      const int first_row = column / T::kLanes * T::kLanes;
      SolvePanel(blocks_.pivot, first_row, size_, column, 0);
      if (blocks_.coupling != nullptr) {
        // Rows from `end` on are zero in the columns of this panel.
        const int block = blocks_.block;
        const int end =
            block > 0 ? ((column + kPanel - 1) / block + 1) * block : size_;
        SolvePanel(blocks_.coupling, 0, end < size_ ? end : size_, column,
                   block);
      }
    }
    if (blocks_.next != nullptr) SubtractSquare();
    return true;
  }

 private:
  static constexpr int kPanel = 4;  // columns
  static constexpr int kTile = 3;   // packs of rows

  // acc -= rows of `left` times rows of `right`, `count` columns of each.
  template <int kPacks>
  KINEGRAPH_INLINE void Subtract(const double* left, const double* right,
                                 int count, T (*acc)[kPanel]) const {
    for (int k = 0; k < count; ++k) {
      T rows[kPacks];
      for (int i = 0; i < kPacks; ++i) rows[i] = T::Load(left + i * T::kLanes);
      for (int j = 0; j < kPanel; ++j) {
        const T by = right[j];
        for (int i = 0; i < kPacks; ++i) acc[i][j] -= rows[i] * by;
      }
      left += size_;
      right += size_;
    }
  }

  double* At(double* square, int row, int column) const {
    return square + static_cast<long>(column) * size_ + row;
  }

  template <int kPacks>
  KINEGRAPH_INLINE void Load(const double* tile, T (*acc)[kPanel]) const {
    for (int j = 0; j < kPanel; ++j) {
      for (int i = 0; i < kPacks; ++i) {
        acc[i][j] =
            T::Load(tile + static_cast<long>(j) * size_ + i * T::kLanes);
      }
    }
  }
  template <int kPacks>
  KINEGRAPH_INLINE void Store(const T (*acc)[kPanel], double* tile) const {
    for (int j = 0; j < kPanel; ++j) {
      for (int i = 0; i < kPacks; ++i) {
        acc[i][j].Store(tile + static_cast<long>(j) * size_ + i * T::kLanes);
      }
    }
  }

  // Cholesky factor of the panel's corner on the diagonal; false if the corner
  // is not positive definite.
  bool FactorCorner(int column) {
    constexpr int kPacks = T::kLanes < kPanel ? kPanel / T::kLanes : 1;
    const int row = column / T::kLanes * T::kLanes;
    T acc[kPacks][kPanel];
    Load<kPacks>(At(blocks_.pivot, row, column), acc);
    Subtract<kPacks>(blocks_.pivot + row, blocks_.pivot + column, column, acc);
    double left[kPanel][kPacks * T::kLanes];
    for (int j = 0; j < kPanel; ++j) {
      for (int i = 0; i < kPacks; ++i) acc[i][j].Store(left[j] + i * T::kLanes);
    }
    for (int i = 0; i < kPanel; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = left[j][column - row + i];
        for (int k = 0; k < j; ++k) sum -= corner_[i][k] * corner_[j][k];
        if (j < i) {
          corner_[i][j] = sum * inverse_[j];
          continue;
        }
        if (!(sum > 0.0 && sum < 1e300)) return false;
        corner_[i][i] = Sqrt(sum);
        inverse_[i] = 1.0 / corner_[i][i];
      }
    }
    return true;
  }

  // Solves rows [begin, end) of a panel, given the columns before it.
  void SolvePanel(double* square, int begin, int end, int column, int block) {
    int row = begin;
    for (; row + kTile * T::kLanes <= size_ && row < end;
         row += kTile * T::kLanes) {
      SolveTile<kTile>(square, row, column, block);
    }
    for (; row < end; row += T::kLanes)
      SolveTile<1>(square, row, column, block);
  }

  int FirstColumn(int row, int block) const {
    return block > 0 ? row / block * block : 0;
  }

  template <int kPacks>
  void SolveTile(double* square, int row, int column, int block) {
    T acc[kPacks][kPanel];
    double* const tile = At(square, row, column);
    Load<kPacks>(tile, acc);
    const int first = FirstColumn(row, block);
    if (first < column) {
      Subtract<kPacks>(At(square, row, first), At(blocks_.pivot, column, first),
                       column - first, acc);
    }
    for (int j = 0; j < kPanel; ++j) {
      for (int i = 0; i < kPacks; ++i) {
        for (int k = 0; k < j; ++k) acc[i][j] -= acc[i][k] * T(corner_[j][k]);
        acc[i][j] *= T(inverse_[j]);
      }
    }
    Store<kPacks>(acc, tile);
  }

  void SubtractSquare() {
    for (int column = 0; column < size_; column += kPanel) {
      int row = column / T::kLanes * T::kLanes;
      for (; row + kTile * T::kLanes <= size_; row += kTile * T::kLanes) {
        SubtractTile<kTile>(row, column);
      }
      for (; row < size_; row += T::kLanes) SubtractTile<1>(row, column);
    }
  }

  template <int kPacks>
  void SubtractTile(int row, int column) {
    T acc[kPacks][kPanel];
    double* const tile = At(blocks_.next, row, column);
    Load<kPacks>(tile, acc);
    const int first = FirstColumn(row, blocks_.block);
    Subtract<kPacks>(At(blocks_.coupling, row, first),
                     At(blocks_.coupling, column, first), size_ - first, acc);
    Store<kPacks>(acc, tile);
  }

  const DenseElimination& blocks_;
  const int size_;
  double corner_[kPanel][kPanel];
  double inverse_[kPanel];  // of the corner's diagonal
};

template <typename T>
bool EliminateDenseWith(const DenseElimination& blocks) {
  return DenseEliminator<T>(blocks).Run();
}

// One entry point per instruction set; only EliminateDense calls them.
bool EliminateDenseAvx2(const DenseElimination& blocks);
bool EliminateDenseAvx512(const DenseElimination& blocks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_DENSE_KERNEL_H_
