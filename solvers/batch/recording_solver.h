// A person's whole recording, solved in chunks.
#ifndef KINEGRAPH_SOLVERS_BATCH_RECORDING_SOLVER_H_
#define KINEGRAPH_SOLVERS_BATCH_RECORDING_SOLVER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "solvers/batch/chunks.h"
#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"
#include "solvers/person/person_solver.h"

namespace kinegraph {

// Does with every chunk of a recording what PersonSolver does with a problem,
// on as many threads as the caller may use; the result is the same for any
// number. What is learnt from the recording (noise, bones) is learnt by the
// caller, over all chunks.
class RecordingSolver {
 public:
  explicit RecordingSolver(const GraphOptions& options);

  const SolveSchedule& schedule() const { return whole_.schedule(); }
  double correction() const { return whole_.correction(); }

  // All joints, each as if alone.
  void SolveJoints(const SolveSchedule& schedule, PersonProblem* recording);

  // Bones if there are any, then Ceres if the options name it.
  void SolveTogether(PersonProblem* recording);

  // Both, in `chunks` alone. False where bones had to be left out.
  bool SolveAnew(const std::vector<Chunk>& chunks, PersonProblem* recording);

  // Whether SolveTogether solved all chunks with the bones that there are.
  bool KeptBones() const;

  // Positions' covariances [joint][frame] in m^2, under what SolveTogether
  // kept; a joint has none where they are not positive definite.
  std::vector<std::vector<Eigen::Matrix3d>> Covariances(
      const PersonProblem& recording);
  // The same of each joint as if alone.
  std::vector<std::vector<Eigen::Matrix3d>> JointCovariances(
      const PersonProblem& recording);
  // Those of whole states, with the information times `correction`.
  std::vector<std::vector<Matrix6d>> StateCovariances(
      const PersonProblem& recording, double correction);

  // SolveTogether and the covariances begin with it: each needs work space of
  // its own kind.
  void FreeWorkSpace();

  void HandInCounts(int64_t first_frame, int64_t last_frame) {
    whole_.HandInCounts(first_frame, last_frame);
  }

 private:
  using Work = std::function<void(PersonSolver*, PersonProblem*)>;

  std::unique_ptr<PersonSolver> AcquireIdle();
  void GiveBack(std::unique_ptr<PersonSolver> solver);
  // Calls visit(chunk's number, solver, chunk as a problem of its own) for
  // every chunk.
  template <typename Visit>
  void ForEachChunk(const PersonProblem& recording,
                    const std::vector<Chunk>& chunks, const Visit& visit);
  // What `of(solver, problem, end of its frames)` says of each chunk, joined.
  template <typename Matrix, typename Of>
  std::vector<std::vector<Matrix>> InChunks(const PersonProblem& recording,
                                            const Of& of);
  // Takes over what `work` does to the chunks' own frames. Whether that dropped
  // their bones, by chunk.
  std::vector<char> Solve(const std::vector<Chunk>& chunks, const Work& work,
                          PersonProblem* recording);

  const GraphOptions options_;
  PersonSolver whole_;
  std::mutex taking_;
  std::vector<std::unique_ptr<PersonSolver>> idle_;  // of chunks, between them
  std::vector<char> without_bones_;  // by chunk: they could not be solved
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BATCH_RECORDING_SOLVER_H_
