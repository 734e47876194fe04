// Counts of how the solves of a run ended.
#ifndef KINEGRAPH_SOLVERS_GRAPH_SOLVE_COUNTS_H_
#define KINEGRAPH_SOLVERS_GRAPH_SOLVE_COUNTS_H_

#include <cstdint>
#include <iterator>
#include <mutex>
#include <set>
#include <string>
#include <utility>

namespace kinegraph {

// Integers only: their sums are the same in any order, so a run's counts do not
// depend on its threads.
struct SolveCounts {
  int64_t solves = 0;  // without those that only provide a start for Ceres
  int64_t sweep_iterations = 0;  // of the block-tridiagonal solver
  int64_t ceres_problems = 0;    // ceres::Problem objects solved
  int64_t ceres_iterations = 0;
  // Decrease of the cost in the last stage of Ceres' solves, in millionths.
  int64_t ceres_decrease_millionths = 0;

  // Failures.
  int64_t not_converged = 0;  // solves that ended before they converged
  int64_t not_finite = 0;     // solves without a finite result
  int64_t bones_dropped = 0;  // solves that continued without bones
  // Positions of one joint in one frame that still moved by 5 cm or more along
  // an axis: their views lost their weight, so that status and covariance
  // reflect it.
  int64_t positions_in_doubt = 0;
  // Problems in which a joint has no covariance, because its information is not
  // positive definite.
  int64_t no_covariance = 0;

  // Whether there are no failures.
  bool AllWell() const;
  SolveCounts& operator+=(const SolveCounts& other);
};

// Every member, for code that handles all counts in one loop.
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

// Text for users: the failures, their effect on the result and the remedy;
// empty without failures. `where` names the people whose solves did not
// converge, by their frames (SolveLedger::NotConverged).
std::string DescribeTroubles(const SolveCounts& counts,
                             const std::string& where = "");

// Collects the counts of a run's estimators, from any thread.
class SolveLedger {
 public:
  // Adds the counts of a person who spans the frames first .. last.
  void Add(const SolveCounts& counts, int64_t first_frame, int64_t last_frame);
  SolveCounts Total() const;
  // Frames of up to three people with solves that did not converge, and the
  // number of the other such people: "a person in frames 0 to 99, one in ...".
  std::string NotConverged() const;

 private:
  mutable std::mutex mutex_;
  SolveCounts total_;
  std::multiset<std::pair<int64_t, int64_t>> not_converged_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_SOLVE_COUNTS_H_
