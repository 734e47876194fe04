// Solves the rectangular linear assignment problem.
#ifndef KINEGRAPH_CORE_ASSIGNMENT_HUNGARIAN_H_
#define KINEGRAPH_CORE_ASSIGNMENT_HUNGARIAN_H_

#include <vector>

#include "core/base/span.h"

namespace kinegraph {

// The Hungarian algorithm (Kuhn 1955) in its shortest-augmenting-path form with
// dual potentials (Jonker and Volgenant 1987): O(n^2 m) for the smaller side n
// and the larger m. Reuses its memory between calls.
//
// Among several optimal assignments the result is the same on every machine:
// ties in the search for the next column go to the lowest index.
class HungarianSolver {
 public:
  // `cost` is row-major; throws std::invalid_argument unless it has rows x cols
  // finite entries. Every row is assigned when rows <= cols, every column
  // otherwise. (*col_of_row)[r] is the column of row r, or -1.
  void Minimise(Span<double> cost, int rows, int cols,
                std::vector<int>* col_of_row);
  // Finds the assignment with the largest total instead.
  void Maximise(Span<double> gain, int rows, int cols,
                std::vector<int>* col_of_row);
  // The largest total of pairs whose gain is > 0; other pairs are not assigned.
  // Groups of rows and columns that no such pair connects are solved
  // separately, which takes less time than one large problem. Throws
  // std::invalid_argument unless `gain` has rows x cols entries, without NaN
  // and positive infinity.
  void MaximisePositive(Span<double> gain, int rows, int cols,
                        std::vector<int>* col_of_row);

 private:
  void Solve(int rows, int cols);

  std::vector<double> cost_;  // its rows are the smaller side
  std::vector<double> row_potential_;
  std::vector<double> col_potential_;
  std::vector<double> path_cost_;
  std::vector<int> row_of_col_;
  std::vector<int> predecessor_;
  std::vector<char> visited_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSIGNMENT_HUNGARIAN_H_
