// Elimination of dense symmetric blocks in lanes.
#ifndef KINEGRAPH_CORE_BASE_DENSE_LANES_H_
#define KINEGRAPH_CORE_BASE_DENSE_LANES_H_

namespace kinegraph {

// Squares of `size` rows, column by column; `size` is a multiple of
// kLaneMultiple. Rows beyond what the caller has are those of the identity in
// `pivot` and zero in `coupling`.
struct DenseElimination {
  int size = 0;
  // Rows of `coupling` come in blocks of so many, each zero left of its own
  // diagonal block; 0: no such structure.
  int block = 0;
  // Symmetric, positive definite, in the lower triangle; becomes its Cholesky
  // factor L. Above the diagonal nothing is read, and anything may be left.
  double* pivot = nullptr;
  // B, the rows that couple what stays with what goes; becomes Y = B L^-T.
  double* coupling = nullptr;
  // Receives -Y Y' on top of what it holds, in the lower triangle. May be null.
  double* next = nullptr;
};

// Eliminates the pivot. With the identity for a coupling, Y Y' is the pivot's
// inverse. False where the pivot is not positive definite.
bool EliminateDense(const DenseElimination& blocks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_DENSE_LANES_H_
