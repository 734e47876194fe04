// Solves a person's problem with the solver that the options name.
#ifndef KINEGRAPH_SOLVERS_PERSON_PERSON_SOLVER_H_
#define KINEGRAPH_SOLVERS_PERSON_PERSON_SOLVER_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "solvers/block_tridiagonal/bone_solver.h"
#include "solvers/block_tridiagonal/chain_solver.h"
#include "solvers/ceres/ceres_solver.h"
#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"
#include "solvers/graph/solve_counts.h"

namespace kinegraph {

// Keeps work space between calls; one a person. A result is made in three
// steps, from states that DLT or an earlier solve has left:
//   SolveJoints  finds the basin, joint by joint: the stages of graduated
//                non-convexity, by block-tridiagonal elimination
//   SolveBones   the same with what couples the joints
//   Refine       finds the minimum: one Ceres problem with all factors of the
//                person, which Ceres ends
// With graph.solver = "sweeps" the last does nothing. With graph.start = "dlt"
// Ceres does the first as well, and the second is none.
class PersonSolver {
 public:
  explicit PersonSolver(const GraphOptions& options);

  // The schedule the options ask for.
  const SolveSchedule& schedule() const { return schedule_; }
  // InformationCorrection of its last loss.
  double correction() const { return correction_; }

  // Gates the measurements at the joints' states and runs `schedule`, each
  // joint as if alone. A solve that finds nothing finite keeps its start, and
  // its measurements get no weight.
  void SolveJoints(const SolveSchedule& schedule, PersonProblem* problem);

  // Couples the joints by the problem's bones, from the estimates that the
  // joints have alone and under the last stage's loss. Where that finds nothing
  // finite those estimates stay and the problem's bones are dropped.
  void SolveBones(PersonProblem* problem);

  // Solver ceres: takes the whole problem, the user's factors included, to
  // convergence under the last stage's loss. Where that finds nothing finite
  // what it started from stays.
  void Refine(PersonProblem* problem);

  // Covariances of the frames before `frame_end` of all joints of a coupled
  // problem; [joint][frame], empty where there are none.
  std::vector<std::vector<Matrix6d>> BoneCovariances(
      const PersonProblem& problem, size_t frame_end);

  // The same of joints that nothing couples.
  std::vector<std::vector<Matrix6d>> JointCovariances(
      const PersonProblem& problem, double correction, size_t frame_end);

  // Gives back the memory that solves needed.
  void FreeWorkSpace();

  // What was counted since the last call.
  SolveCounts ExtractCounts();
  // Counts what another one has.
  void AddCounts(const SolveCounts& counts) { counts_ += counts; }

  // Adds what was counted since the last call to the options' ledger, and logs
  // what went wrong in the frames first .. last of this person.
  void HandInCounts(int64_t first_frame, int64_t last_frame);

 private:
  // What becomes of a solve: the estimator goes on with it, or Ceres does.
  enum class Result { kTakenOver, kOnlyAStart };
  // Counts a solve.
  void Note(const SolveReport& report, Result result);
  void SolveJointsWithCeres(const SolveSchedule& schedule,
                            PersonProblem* problem);

  GraphSolver solver_;
  GraphStart start_;
  std::shared_ptr<SolveLedger> ledger_;
  SolveCounts counts_;
  SolveSchedule schedule_;
  SolveSchedule last_stage_;  // of it
  double correction_;
  ChainSolver chain_solver_;
  BoneSolver bone_solver_;
  CeresSolver ceres_solver_;
  CeresSolver ceres_start_;          // start dlt: of problems without couplings
  std::vector<JointChain*> chains_;  // work space
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_PERSON_PERSON_SOLVER_H_
