// Elimination of dense symmetric blocks in lanes.
#ifndef KINEGRAPH_CORE_BASE_DENSE_LANES_H_
#define KINEGRAPH_CORE_BASE_DENSE_LANES_H_

namespace kinegraph {

// Square matrices of `size` rows, stored by columns; `size` is a multiple of
// kLaneMultiple. Padding rows are those of the identity in `pivot` and zero in
// `coupling`.
struct DenseElimination {
  int size = 0;
  // Rows of `coupling` come in blocks of this size, each zero to the left of
  // the diagonal block; 0: no such structure.
  int block = 0;
  // Symmetric positive definite, lower triangle; replaced by its Cholesky
  // factor L. Entries above the diagonal are neither read nor preserved.
  double* pivot = nullptr;
  // B, the rows between the remaining and the eliminated variables; replaced by
  // Y = B L^-T. May be null if `next` is.
  double* coupling = nullptr;
  // Y Y' is subtracted from its lower triangle. May be null.
  double* next = nullptr;
};

// Eliminates the pivot. With the identity as coupling, Y Y' is the pivot's
// inverse. False if the pivot is not positive definite.
bool EliminateDense(const DenseElimination& blocks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_DENSE_LANES_H_
