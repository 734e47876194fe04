// Which frames of a person an earlier pass has solved already.
#ifndef KINEGRAPH_SOLVERS_BATCH_KNOWN_FRAMES_H_
#define KINEGRAPH_SOLVERS_BATCH_KNOWN_FRAMES_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "solvers/batch/chunks.h"
#include "solvers/batch/person_recording.h"
#include "solvers/noise/solved_person.h"

namespace kinegraph {

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
void PasteKnown(const KnownFrames& known, PersonRecording* recording);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BATCH_KNOWN_FRAMES_H_
