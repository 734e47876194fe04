// The list of a joint's factors, for one joint and for a pack of joints.
//
// Who walks it hands in a chain, which makes each factor of its own numbers
// (doubles in solvers/graph/factor_list.h, packs in
// solvers/block_tridiagonal/chain_kernel.h), and a visitor that takes every one
// of them: a factor that is listed here and that a chain or a visitor does not
// know is an error of the compiler.
#ifndef KINEGRAPH_SOLVERS_FACTORS_JOINT_FACTORS_H_
#define KINEGRAPH_SOLVERS_FACTORS_JOINT_FACTORS_H_

#include "core/base/pack.h"

namespace kinegraph {

// Visits the factors whose earliest state is that of frame k, as
//   bool visit(const Factor& factor, const Chain::Counting& counting)
// on the states of frames k .. k + Factor::kKeys - 1; false ends the walk. A
// chain has
//   frame_count()
//   HasPrior(), Prior()           on the state of frame 0
//   Motion(k)                     from frame k to frame k + 1
//   PixelsBegin(k), PixelsEnd(k)  the measurements of frame k
//   IsLeftOut(m), Pixel(m)        of measurement m
//   Always(), CountingOf(m)       what the visitor is told of how a factor, and
//                                 measurement m, counts
template <typename Chain, typename Frame, typename Visit>
KINEGRAPH_INLINE bool ForEachFactorOfFrame(const Chain& chain, Frame k,
                                           Visit&& visit) {
  if (k == 0 && chain.HasPrior() && !visit(chain.Prior(), chain.Always())) {
    return false;
  }
  if (k + 1 < chain.frame_count() && !visit(chain.Motion(k), chain.Always())) {
    return false;
  }
  for (auto m = chain.PixelsBegin(k); m < chain.PixelsEnd(k); ++m) {
    if (chain.IsLeftOut(m)) continue;
    if (!visit(chain.Pixel(m), chain.CountingOf(m))) return false;
  }
  return true;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_JOINT_FACTORS_H_
