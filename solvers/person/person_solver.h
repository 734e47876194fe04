// Solves a person's problem with the configured solver.
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

// Reuses work space between calls, so it must not be shared between threads. A
// solve has three steps, starting from the states left by DLT or an earlier
// solve:
//   SolveJoints  finds the basin, joint by joint: the stages of graduated
//                non-convexity, by block-tridiagonal elimination
//   SolveBones   runs the last stage with bones and PersonProblem::prior
//   Refine       finds the minimum: one Ceres problem with all factors of the
//                person, run to convergence
// With graph.solver = "sweeps" Refine does nothing. With graph.start = "dlt"
// Ceres also performs SolveJoints, and SolveBones does nothing.
class PersonSolver {
 public:
  explicit PersonSolver(const GraphOptions& options);

  // The schedule that the options define.
  const SolveSchedule& schedule() const { return schedule_; }
  // InformationCorrection of the schedule's last loss, with its scale times
  // kLearntWidening if pixel noise is learnt.
  double correction() const { return correction_; }

  // Gates the measurements at the joints' states and runs `schedule` for each
  // joint independently. A joint without a finite result keeps its start, and
  // its measurements get no weight; with graph.start = "dlt", all joints keep
  // the start of the stage that failed, and all measurements their weights.
  void SolveJoints(const SolveSchedule& schedule, PersonProblem* problem);

  // Couples the joints by the problem's bones and prior, starting from the
  // independent estimates, under the last stage's loss. Without a finite
  // result, the independent estimates are kept and the problem's bones dropped.
  void SolveBones(PersonProblem* problem);

  // With graph.solver = "ceres": solves the whole problem, including the user's
  // factors, to convergence under the last stage's loss. Without a finite
  // result, the start is kept; with graph.start = "dlt", where the start was
  // found without bones, the problem's bones are dropped.
  void Refine(PersonProblem* problem);

  // SolveJoints with the schedule of the options, and Refine. With graph.start
  // = "dlt" one Ceres problem performs both, unless something couples the
  // joints.
  void SolveJointsAndRefine(PersonProblem* problem);

  // Covariances of the frames before `frame_end` of all joints of a coupled
  // problem; [joint][frame], empty if undefined.
  std::vector<std::vector<Matrix6d>> BoneCovariances(
      const PersonProblem& problem, size_t frame_end);

  // Covariances of the frames before `frame_end`, ignoring couplings between
  // the joints; [joint][frame], empty for a joint where they are undefined.
  std::vector<std::vector<Matrix6d>> JointCovariances(
      const PersonProblem& problem, double correction, size_t frame_end);

  // Frees the memory that solves needed.
  void FreeWorkSpace();

  // The counts since the last call.
  SolveCounts ExtractCounts();
  // Adds the counts of another solver.
  void AddCounts(const SolveCounts& counts) { counts_ += counts; }

  // Adds the counts since the last call to the options' ledger, and logs
  // failures in the frames first .. last of this person.
  void HandInCounts(int64_t first_frame, int64_t last_frame);

 private:
  // Whether a solve's result is kept or only serves as the start for Ceres.
  enum class Result { kTakenOver, kOnlyAStart };
  // Counts a solve.
  void Note(const SolveReport& report, Result result);
  // Covariances must not include factors that the estimates did not use. Does
  // nothing without bones.
  void DropBones(PersonProblem* problem);
  void SolveJointsWithCeres(const SolveSchedule& schedule,
                            PersonProblem* problem);

  GraphSolver solver_;
  GraphStart start_;
  std::shared_ptr<SolveLedger> ledger_;
  SolveCounts counts_;
  SolveSchedule schedule_;
  SolveSchedule last_stage_;  // of the schedule
  double correction_;
  ChainSolver chain_solver_;
  BoneSolver bone_solver_;
  CeresSolver ceres_solver_;
  // With graph.start = "dlt": solves the joints without their couplings.
  CeresSolver ceres_start_;
  std::vector<JointChain*> chains_;  // work space
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_PERSON_PERSON_SOLVER_H_
