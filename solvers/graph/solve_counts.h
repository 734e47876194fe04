// How the solves of a run ended, counted.
#ifndef KINEGRAPH_SOLVERS_GRAPH_SOLVE_COUNTS_H_
#define KINEGRAPH_SOLVERS_GRAPH_SOLVE_COUNTS_H_

#include <cstdint>
#include <iterator>
#include <mutex>
#include <set>
#include <string>
#include <utility>

namespace kinegraph {

// Whole numbers only: their sums are the same in any order, so a run's counts
// do not depend on its threads.
struct SolveCounts {
  int64_t solves = 0;            // results that an estimator took over
  int64_t sweep_iterations = 0;  // of the block-tridiagonal solver
  int64_t ceres_problems = 0;    // ceres::Problem objects solved
  int64_t ceres_iterations = 0;
  // Decrease of the cost from the start to Ceres' result [1e-6].
  int64_t ceres_decrease_millionths = 0;

  // What went wrong.
  int64_t not_converged = 0;  // solves that reached their iterations
  int64_t not_finite = 0;     // solves that found nothing finite
  int64_t bones_dropped = 0;  // solves that went on without bones
  // Positions of one joint in one frame that still moved by more than 5 cm:
  // their views lost their weight, so that status and covariance say so.
  int64_t positions_in_doubt = 0;
  int64_t no_covariance = 0;  // not positive definite

  // Whether everything was solved as it should be.
  bool AllWell() const;
  SolveCounts& operator+=(const SolveCounts& other);
};

// All of them.
inline constexpr int64_t SolveCounts::*kSolveCounts[] = {
    &SolveCounts::solves,
    &SolveCounts::sweep_iterations,
    &SolveCounts::ceres_problems,
    &SolveCounts::ceres_iterations,
    &SolveCounts::ceres_decrease_millionths,
    &SolveCounts::not_converged,
    &SolveCounts::not_finite,
    &SolveCounts::bones_dropped,
    &SolveCounts::positions_in_doubt,
    &SolveCounts::no_covariance};
static_assert(sizeof(SolveCounts) == sizeof(int64_t) * std::size(kSolveCounts),
              "a count is missing above");

// What went wrong, what that means for the result and what helps, for people;
// empty where nothing did. `where` says which frames did not converge.
std::string DescribeTroubles(const SolveCounts& counts,
                             const std::string& where = "");

// Where a run's estimators add their counts, from any thread.
class SolveLedger {
 public:
  // Of a person of the frames first .. last.
  void Add(const SolveCounts& counts, int64_t first_frame, int64_t last_frame);
  SolveCounts Total() const;
  // The people who did not converge, by their frames: "a person of frames 0 to
  // 99, ..."; the first three of them.
  std::string NotConverged() const;

 private:
  mutable std::mutex mutex_;
  SolveCounts total_;
  std::multiset<std::pair<int64_t, int64_t>> not_converged_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_SOLVE_COUNTS_H_
