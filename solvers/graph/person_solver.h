// Solves a person's problem with the solver that the options name.
#ifndef KINEGRAPH_SOLVERS_GRAPH_PERSON_SOLVER_H_
#define KINEGRAPH_SOLVERS_GRAPH_PERSON_SOLVER_H_

#include <vector>

#include "solvers/graph/bone_solver.h"
#include "solvers/graph/chain_solver.h"
#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Keeps work space between calls; one a person.
class PersonSolver {
 public:
  explicit PersonSolver(const GraphOptions& options);

  // The schedule the options ask for.
  const SolveSchedule& schedule() const { return schedule_; }
  // InformationCorrection of its last loss.
  double correction() const { return correction_; }

  // Gates the measurements of a joint at its states and runs `schedule`. A
  // solve that finds nothing finite keeps its start, its measurements get no
  // weight, and the log says so.
  void SolveJoint(const SolveSchedule& schedule, int joint_idx,
                  PersonProblem* problem);

  // Couples the joints by the problem's bones, from the estimates that the
  // joints have alone and under the last stage's loss. Where that finds nothing
  // finite those estimates stay and the problem's bones are dropped.
  void SolveBones(PersonProblem* problem);

  // Covariances of the frames before `frame_end` of all joints, bones included;
  // [joint][frame], empty where there are none.
  std::vector<std::vector<Matrix6d>> BoneCovariances(
      const PersonProblem& problem, size_t frame_end) const;

  // Covariances of all frames of a joint; empty where there are none. Valid
  // until the next call.
  const std::vector<Matrix6d>& JointCovariances(const PersonProblem& problem,
                                                int joint_idx,
                                                double correction);

 private:
  GraphSolver solver_;
  SolveSchedule schedule_;
  double correction_;
  ChainSolver chain_solver_;
  BoneSolver bone_solver_;
  std::vector<State> start_;
  std::vector<Matrix6d> covariances_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_PERSON_SOLVER_H_
