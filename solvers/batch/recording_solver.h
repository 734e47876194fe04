// Solves a person's whole recording in independent chunks.
//
// Observations more than a second or two away have almost no influence on a
// joint. A chunk that overlaps its neighbours on both sides therefore gives the
// same result for its own frames as the whole recording would. Chunks are
// solved in parallel and fit into the processor's cache.
#ifndef KINEGRAPH_SOLVERS_BATCH_RECORDING_SOLVER_H_
#define KINEGRAPH_SOLVERS_BATCH_RECORDING_SOLVER_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "solvers/graph/options.h"
#include "solvers/graph/outcome.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/recording_notes.h"
#include "solvers/person/person_solver.h"

namespace kinegraph {

struct Chunk {
  // Frames begin .. end - 1 are solved, and own_begin .. own_end - 1 of them
  // kept. Each frame is owned by exactly one of the chunks from MakeChunks.
  size_t begin = 0;
  size_t end = 0;
  size_t own_begin = 0;
  size_t own_end = 0;
};

// Chunks of equal duration, at least `chunk_s` and less than twice that [s]; a
// single chunk if `chunk_s` is 0 or the recording is shorter than 2 `chunk_s`.
// They depend only on times and on which frames measure which joints. The
// overlap is 1.1 s on each side (over which a change in one frame affects
// others; 27 frames at 25 Hz), and up to 5.5 s where a joint is measured in
// fewer than half of these frames.
std::vector<Chunk> MakeChunks(const PersonProblem& problem, double chunk_s);

// The result for a chunk's own frames, of all joints.
std::vector<JointOutcome> OutcomesOf(const PersonProblem& part,
                                     const Chunk& chunk);

// The frames of a person that an earlier pass has already solved.
struct KnownFrames {
  std::shared_ptr<const SolvedPerson> person;
  // By frame: index in person->records of the same frame, or of one near it.
  std::vector<size_t> frame_of;
  // By frame: matched and measured as in the earlier pass.
  std::vector<char> same;
};

// The first of `people` whose matches and numbers of measurements differ in at
// most 1/400 of the frames (of the longer of the two tracks), if any. So few
// changes hardly affect noise and bones.
std::optional<KnownFrames> FindKnownFrames(
    const std::vector<std::shared_ptr<const SolvedPerson>>& people,
    const std::vector<FrameRecord>& records, const PersonProblem& graph);

// Chunks that own the frames up to 1.1 s (the overlap of MakeChunks) before or
// after any frame that is not `same`.
std::vector<Chunk> ChangedChunks(const PersonProblem& problem,
                                 const std::vector<char>& same);

// Copies the earlier pass's result into the frames marked in `known.same`.
void PasteKnown(const KnownFrames& known, PersonProblem* recording);

// Applies PersonSolver to every chunk of a recording, on as many threads as the
// caller may use; the result does not depend on their number. Noise and bones
// are learnt by the caller, over all chunks.
class RecordingSolver {
 public:
  explicit RecordingSolver(const GraphOptions& options);

  const SolveSchedule& schedule() const { return whole_.schedule(); }

  // Solves each joint independently.
  void SolveJoints(const SolveSchedule& schedule, PersonProblem* recording);

  // Solves with bones, if there are any, then with Ceres if the options select
  // it.
  void SolveTogether(PersonProblem* recording);

  // SolveJoints and SolveTogether for `chunks` only. False if bones had to be
  // left out.
  bool SolveAnew(const std::vector<Chunk>& chunks, PersonProblem* recording);

  // Whether SolveTogether solved all chunks with their bones.
  bool KeptBones() const;

  // Covariances of positions [joint][frame] in m^2, with the bones that
  // SolveTogether kept; empty for a joint where they are not positive definite.
  std::vector<std::vector<Eigen::Matrix3d>> Covariances(
      const PersonProblem& recording);
  // Covariances of positions with each joint treated independently.
  std::vector<std::vector<Eigen::Matrix3d>> JointCovariances(
      const PersonProblem& recording);
  // Covariances of whole states, with the information times `correction`.
  std::vector<std::vector<Matrix6d>> StateCovariances(
      const PersonProblem& recording, double correction);

  // Frees the memory that solves needed. SolveTogether and the functions that
  // compute covariances begin with this call, because each needs its own work
  // space.
  void FreeWorkSpace();

  // PersonSolver::HandInCounts for the counts of all chunks.
  void HandInCounts(int64_t first_frame, int64_t last_frame) {
    whole_.HandInCounts(first_frame, last_frame);
  }

 private:
  using Work = std::function<void(PersonSolver*, PersonProblem*)>;

  // Calls visit(chunk index, solver, chunk as a separate problem) for every
  // chunk.
  template <typename Visit>
  void ForEachChunk(const PersonProblem& recording,
                    const std::vector<Chunk>& chunks, const Visit& visit);
  // Concatenates the chunks' own frames of `of(solver, problem, end)`, which
  // computes those before `end`, the end of the own frames in the chunk's
  // problem.
  template <typename Matrix, typename Of>
  std::vector<std::vector<Matrix>> InChunks(const PersonProblem& recording,
                                            const Of& of);
  // Applies `work` and keeps the result in the chunks' own frames. Returns by
  // chunk whether it dropped the bones.
  std::vector<char> Solve(const std::vector<Chunk>& chunks, const Work& work,
                          PersonProblem* recording);

  const GraphOptions options_;
  PersonSolver whole_;
  std::mutex taking_;  // protects idle solvers and counts
  std::vector<std::unique_ptr<PersonSolver>> idle_;  // solvers not in use
  std::vector<char> without_bones_;  // by chunk: solved without bones
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BATCH_RECORDING_SOLVER_H_
