// Long recordings in chunks that are solved on their own.
//
// What lies a second or two away has next to no say in where a joint is, so a
// chunk with some frames of its neighbours on both sides finds, in its own
// frames, what the whole recording would. Chunks are solved in parallel, and
// stay in the processor's cache.
#ifndef KINEGRAPH_SOLVERS_BATCH_CHUNKS_H_
#define KINEGRAPH_SOLVERS_BATCH_CHUNKS_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "solvers/graph/outcome.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/recording_notes.h"

namespace kinegraph {

// How far what changes in a frame is felt [s]; 28 frames at 25 Hz.
inline constexpr double kOverlap_s = 1.1;

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
// longer. The overlap is kOverlap_s on each side, and up to 5.5 s where a joint
// is measured in less than half of that.
std::vector<Chunk> MakeChunks(const PersonProblem& problem, double chunk_s);

// One that owns all frames in which a change of frames begin .. end - 1 is
// felt.
Chunk ChunkAround(const PersonProblem& problem, size_t begin, size_t end);

// The chunk as a problem of its own. Where the recording goes on before it, its
// first states have the prior of a birth at their starts.
PersonProblem CutOut(const PersonProblem& recording, const Chunk& chunk);

// What a solve found for a chunk's own frames, of all joints.
std::vector<JointOutcome> OutcomesOf(const PersonProblem& part,
                                     const Chunk& chunk);

// Writes those of all joints into the whole.
void Paste(const std::vector<JointOutcome>& outcomes, const Chunk& chunk,
           PersonProblem* recording);

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

// Chunks whose own frames are those that changed and what is near them.
std::vector<Chunk> ChangedChunks(const PersonProblem& problem,
                                 const std::vector<char>& same);

// Writes what the earlier pass found into the frames marked as the same.
void PasteKnown(const KnownFrames& known, PersonProblem* recording);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BATCH_CHUNKS_H_
