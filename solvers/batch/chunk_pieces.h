// What is found out about chunks, as pieces that are kept (PieceStore).
#ifndef KINEGRAPH_SOLVERS_BATCH_CHUNK_PIECES_H_
#define KINEGRAPH_SOLVERS_BATCH_CHUNK_PIECES_H_

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "solvers/batch/chunks.h"
#include "solvers/graph/problem.h"
#include "solvers/person/person_solver.h"

namespace kinegraph {

// What a solve found in a chunk's own frames.
struct ChunkSolution {
  std::vector<JointOutcome> joints;
  bool bones_dropped = false;  // they could not be solved
};

// Of a chunk's own frames, [joint][frame]; a joint has none where it is not
// known.
template <typename Matrix>
using ChunkCovariances = std::vector<std::vector<Matrix>>;

// The key of what `step` makes of a chunk, by all that its result depends on:
// solver, problem and which frames are kept. `step` tells the kinds of work
// apart, with the numbers that it is given. Empty: the problem has factors of
// the caller's own, which nobody can tell apart.
std::string ChunkKey(std::string_view step, const PersonSolver& solver,
                     const Chunk& chunk, const PersonProblem& part);

// To bytes and back, every bit.
void Put(const SolveCounts& counts, ByteWriter* writer);
void Get(ByteReader* reader, SolveCounts* counts);
void Put(const ChunkSolution& solution, ByteWriter* writer);
void Get(ByteReader* reader, ChunkSolution* solution);

template <typename Matrix>
void Put(const ChunkCovariances<Matrix>& covariances, ByteWriter* writer) {
  writer->PutSize(covariances.size());
  for (const std::vector<Matrix>& of_joint : covariances) {
    writer->PutSize(of_joint.size());
    for (const Matrix& covariance : of_joint) writer->PutMatrix(covariance);
  }
}

template <typename Matrix>
void Get(ByteReader* reader, ChunkCovariances<Matrix>* covariances) {
  covariances->resize(reader->GetSize(sizeof(uint64_t)));
  for (std::vector<Matrix>& of_joint : *covariances) {
    of_joint.resize(reader->GetSize(sizeof(Matrix)));
    for (Matrix& covariance : of_joint) reader->GetMatrix(&covariance);
  }
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BATCH_CHUNK_PIECES_H_
