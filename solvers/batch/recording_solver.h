// A person's whole recording, in chunks that are solved on their own.
//
// What lies a second or two away has next to no say in where a joint is, so a
// chunk with some frames of its neighbours on both sides finds, in its own
// frames, what the whole recording would. Chunks are solved in parallel, and
// stay in the processor's cache.
#ifndef KINEGRAPH_SOLVERS_BATCH_RECORDING_SOLVER_H_
#define KINEGRAPH_SOLVERS_BATCH_RECORDING_SOLVER_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "solvers/graph/options.h"
#include "solvers/graph/outcome.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/recording_notes.h"
#include "solvers/person/person_solver.h"

namespace kinegraph {

struct Chunk {
  // Frames begin .. end - 1 are solved, of which own_begin .. own_end - 1 are
  // kept. Every frame is some chunk's own.
  size_t begin = 0;
  size_t end = 0;
  size_t own_begin = 0;
  size_t own_end = 0;
};

// By times and counts of measurements: chunks whose own frames span about
// `chunk_s` [s]; one of everything where it is 0 or the recording is not much
// longer. The overlap is 1.1 s on each side (how far what changes in a frame is
// felt; 28 frames at 25 Hz), and up to 5.5 s where a joint is measured in less
// than half of that.
std::vector<Chunk> MakeChunks(const PersonProblem& problem, double chunk_s);

// What a solve found for a chunk's own frames, of all joints.
std::vector<JointOutcome> OutcomesOf(const PersonProblem& part,
                                     const Chunk& chunk);

// Which frames of a person an earlier pass has solved already.
struct KnownFrames {
  std::shared_ptr<const SolvedPerson> person;
  // By frame: that of the earlier pass, or of the nearest that it had.
  std::vector<size_t> frame_of;
  // By frame: matched and measured as in the earlier pass.
  std::vector<char> same;
};

// The one of `people` whose frames are these but for a fiftieth, if there is
// one. So few other matches, mostly of one view, tell next to nothing new of
// noise and bones.
std::optional<KnownFrames> FindKnownFrames(
    const std::vector<std::shared_ptr<const SolvedPerson>>& people,
    const std::vector<FrameRecord>& records, const PersonProblem& graph);

// Chunks whose own frames are all in which a change of those that are not the
// same is felt.
std::vector<Chunk> ChangedChunks(const PersonProblem& problem,
                                 const std::vector<char>& same);

// Writes what the earlier pass found into the frames marked as the same.
void PasteKnown(const KnownFrames& known, PersonProblem* recording);

// Does with every chunk of a recording what PersonSolver does with a problem,
// on as many threads as the caller may use; the result is the same for any
// number. What is learnt from the recording (noise, bones) is learnt by the
// caller, over all chunks.
class RecordingSolver {
 public:
  explicit RecordingSolver(const GraphOptions& options);

  const SolveSchedule& schedule() const { return whole_.schedule(); }

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
  std::mutex taking_;  // of idle solvers, and of what they counted
  std::vector<std::unique_ptr<PersonSolver>> idle_;  // of chunks, between them
  std::vector<char> without_bones_;  // by chunk: they could not be solved
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BATCH_RECORDING_SOLVER_H_
