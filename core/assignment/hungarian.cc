#include "core/assignment/hungarian.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

namespace kinegraph {
namespace {

// A connected component of the graph whose edges are the pairs of positive
// gain.
struct AssignmentPart {
  std::vector<int> rows;
  std::vector<int> cols;
};

// Union-find: the node that represents the component of `node`. Columns are
// numbered after rows.
int RootOf(int node, std::vector<int>* parent) {
  while ((*parent)[node] != node) {
    (*parent)[node] = (*parent)[(*parent)[node]];
    node = (*parent)[node];
  }
  return node;
}

// `what`: "cost" or "gain".
void CheckSize(const std::string& what, size_t size, int rows, int cols) {
  if (rows < 0 || cols < 0 ||
      size != static_cast<size_t>(rows) * static_cast<size_t>(cols)) {
    throw std::invalid_argument("assignment: " + what +
                                " does not have rows x cols entries");
  }
}

std::vector<AssignmentPart> PartsOf(Span<double> gain, int rows, int cols) {
  std::vector<int> parent(rows + cols);
  std::iota(parent.begin(), parent.end(), 0);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      if (!(gain[r * cols + c] > 0.0)) continue;
      parent[RootOf(rows + c, &parent)] = RootOf(r, &parent);
    }
  }
  std::vector<AssignmentPart> parts(rows + cols);
  for (int node = 0; node < rows + cols; ++node) {
    AssignmentPart& part = parts[RootOf(node, &parent)];
    if (node < rows) {
      part.rows.push_back(node);
    } else {
      part.cols.push_back(node - rows);
    }
  }
  return parts;
}

}  // namespace

void HungarianSolver::Minimise(Span<double> cost, int rows, int cols,
                               std::vector<int>* col_of_row) {
  CheckSize("cost", cost.size(), rows, cols);
  for (const double c : cost) {
    if (!std::isfinite(c)) {
      throw std::invalid_argument("assignment: a cost is not finite");
    }
  }
  col_of_row->assign(rows, -1);
  if (rows == 0 || cols == 0) return;
  const bool transposed = rows > cols;
  const int n = transposed ? cols : rows;
  const int m = transposed ? rows : cols;
  cost_.resize(cost.size());
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      cost_[transposed ? c * m + r : r * m + c] = cost[r * cols + c];
    }
  }
  Solve(n, m);
  for (int c = 0; c < m; ++c) {
    const int r = row_of_col_[c];
    if (r < 0) continue;
    if (transposed) {
      (*col_of_row)[c] = r;
    } else {
      (*col_of_row)[r] = c;
    }
  }
}

void HungarianSolver::Maximise(Span<double> gain, int rows, int cols,
                               std::vector<int>* col_of_row) {
  std::vector<double> cost(gain.size());
  for (size_t i = 0; i < gain.size(); ++i) cost[i] = -gain[i];
  Minimise(cost, rows, cols, col_of_row);
}

void HungarianSolver::MaximisePositive(Span<double> gain, int rows, int cols,
                                       std::vector<int>* col_of_row) {
  CheckSize("gain", gain.size(), rows, cols);
  // Minimise() checks those that are positive.
  for (const double g : gain) {
    if (std::isnan(g)) {
      throw std::invalid_argument("assignment: a gain is not a number");
    }
  }
  col_of_row->assign(rows, -1);
  std::vector<double> cost;
  std::vector<int> chosen;
  for (const AssignmentPart& part : PartsOf(gain, rows, cols)) {
    if (part.rows.empty() || part.cols.empty()) continue;
    cost.clear();
    for (const int r : part.rows) {
      for (const int c : part.cols) {
        cost.push_back(-std::max(0.0, gain[r * cols + c]));
      }
    }
    Minimise(cost, static_cast<int>(part.rows.size()),
             static_cast<int>(part.cols.size()), &chosen);
    for (size_t i = 0; i < chosen.size(); ++i) {
      if (chosen[i] < 0) continue;
      const int r = part.rows[i];
      const int c = part.cols[chosen[i]];
      if (gain[r * cols + c] > 0.0) (*col_of_row)[r] = c;
    }
  }
}

// Adds the rows one by one; each is assigned along the shortest augmenting path
// in reduced costs, which keeps the potentials feasible.
void HungarianSolver::Solve(int rows, int cols) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  row_potential_.assign(rows, 0.0);
  col_potential_.assign(cols, 0.0);
  row_of_col_.assign(cols, -1);
  path_cost_.resize(cols);
  predecessor_.resize(cols);
  visited_.resize(cols);
  for (int start = 0; start < rows; ++start) {
    for (int c = 0; c < cols; ++c) {
      path_cost_[c] = kInfinity;
      predecessor_[c] = -1;
      visited_[c] = 0;
    }
    int row = start;
    int reached = -1;  // column through which `row` was entered
    double distance = 0.0;
    while (true) {
      int next = -1;
      for (int c = 0; c < cols; ++c) {
        if (visited_[c]) continue;
        const double through = distance + cost_[row * cols + c] -
                               row_potential_[row] - col_potential_[c];
        if (through < path_cost_[c]) {
          path_cost_[c] = through;
          predecessor_[c] = reached;
        }
        if (next < 0 || path_cost_[c] < path_cost_[next]) next = c;
      }
      distance = path_cost_[next];
      visited_[next] = 1;
      reached = next;
      if (row_of_col_[next] < 0) break;
      row = row_of_col_[next];
    }
    row_potential_[start] += distance;
    for (int c = 0; c < cols; ++c) {
      if (!visited_[c] || row_of_col_[c] < 0) continue;
      row_potential_[row_of_col_[c]] += distance - path_cost_[c];
    }
    for (int c = 0; c < cols; ++c) {
      if (visited_[c]) col_potential_[c] -= distance - path_cost_[c];
    }
    while (reached >= 0) {
      const int previous = predecessor_[reached];
      row_of_col_[reached] = previous < 0 ? start : row_of_col_[previous];
      reached = previous;
    }
  }
}

}  // namespace kinegraph
