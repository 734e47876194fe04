// Pieces of a comparison that are kept in its checkpoint.
#ifndef KINEGRAPH_APPS_COMPARE_PIECES_H_
#define KINEGRAPH_APPS_COMPARE_PIECES_H_

#include <string>
#include <vector>

#include "apps/compare/comparison.h"
#include "core/base/bytes.h"

namespace kinegraph {

// Comparison::content.
std::string PieceContent(const Comparison& comparison);

// The key of a piece: `what` it is, of which strategy with which values,
// without which view (-1: with all).
std::string PieceKey(const Comparison& comparison, const std::string& what,
                     const Strategy& strategy, const FoldValues& values,
                     int view);

// The piece as kept, else as `compute` makes it, which is then kept.
// `put` and `get` are its way to bytes and back.
template <typename Compute, typename PutPiece, typename GetPiece>
void ComputeOrFind(const Comparison& comparison, const std::string& key,
                   const Compute& compute, const PutPiece& put,
                   const GetPiece& get) {
  if (comparison.checkpoint == nullptr) {
    compute();
    return;
  }
  if (const auto kept = comparison.checkpoint->Find(key)) {
    ByteReader reader(*kept);
    get(&reader);
    return;
  }
  compute();
  ByteWriter writer;
  put(&writer);
  comparison.checkpoint->Add(key, writer.bytes());
}

void Put(const StrategyRun& run, ByteWriter* writer);
// All but the tracks' header and `alike`.
StrategyRun GetStrategyRun(ByteReader* reader);
void Put(const HeldOutScores& scores, ByteWriter* writer);
HeldOutScores GetHeldOutScores(ByteReader* reader);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_PIECES_H_
