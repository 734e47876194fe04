// A person's whole recording as one problem, most of which is packed until it
// is looked at.
#ifndef KINEGRAPH_SOLVERS_BATCH_PERSON_RECORDING_H_
#define KINEGRAPH_SOLVERS_BATCH_PERSON_RECORDING_H_

#include <cstddef>
#include <functional>
#include <vector>

#include "core/tracking/packed_frames.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/packed_measurements.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

struct PersonRecording {
  // All but the measurements; chains say how many there are (`first`).
  PersonProblem graph;
  PackedMeasurements measurements;

  size_t frame_count() const { return graph.times.size(); }

  // Frames begin .. end - 1 with their measurements, chain by chain: without
  // what couples joints, with the chains' priors where it begins with the
  // recording.
  PersonProblem Part(size_t begin, size_t end) const;

  // Frames begin .. end - 1 as the first ones of `part`, which has one frame
  // more where there is one, as motion leads to it.
  struct Piece {
    size_t begin = 0;
    size_t end = 0;
    PersonProblem part;
  };
  // Calls visit for pieces that together are all frames, in order.
  void ForEachPiece(const std::function<void(const Piece&)>& visit) const;
  // The same; takes over what visit does to sigmas, information and bias.
  void ChangeNoise(const std::function<void(Piece*)>& visit);

 private:
  // The piece that follows `piece`; false at the end.
  bool Next(Piece* piece) const;
};

// What Assembler::Append makes of all frames; they are gone then. `records` are
// what it returned. The assembler is new.
PersonRecording AssembleRecording(PackedFrames* frames, Assembler* assembler,
                                  std::vector<FrameRecord>* records);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BATCH_PERSON_RECORDING_H_
