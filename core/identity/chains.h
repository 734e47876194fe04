// Decides which pieces of tracks belong to one person.
#ifndef KINEGRAPH_CORE_IDENTITY_CHAINS_H_
#define KINEGRAPH_CORE_IDENTITY_CHAINS_H_

#include <vector>

#include "core/identity/bones.h"
#include "core/identity/options.h"
#include "core/identity/tracklet.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Pieces that belong to one person.
struct Chain {
  std::vector<int> pieces;  // ascending in time
  BoneSamples bones;
  int number = 0;  // never reused
};

// Evidence for a join, as log odds [nats].
struct Evidence {
  bool allowed = false;
  double bones = 0.0;
  double motion = 0.0;
  double other = 0.0;  // prior, duration of the absence, continuity and hints
  double total() const { return bones + motion + other; }
};

// A piece and its successor.
struct Link {
  int from = 0;  // pieces
  int to = 0;
  Evidence evidence;
  double gap_s = 0.0;
  double bone_difference_m = 0.0;
  // Advantage over the best explanation in which the two are different people
  // [nats]; 0 for a join that only LinkOptions::people decides.
  double margin = 0.0;
  bool decided = false;
};

struct LinkedPieces {
  Pieces pieces;
  std::vector<Chain> chains;
  std::vector<Link> links;      // joins within the chains, except those that
                                // only keep what the tracker had joined
  std::vector<Link> undecided;  // best candidates that were not joined
};

// Cuts the tracks at contacts and joins the pieces that are clearly one person:
// one assignment over all of them, repeated until there are no new clear joins.
// Then restores the tracker's continuations that are not clearly wrong and, if
// LinkOptions::people is given, joins further until at most that many chains
// are left, or no join is possible.
LinkedPieces JoinPieces(const Skeleton& skeleton, double frame_rate_hz,
                        const LinkOptions& options,
                        const std::vector<Tracklet>& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_CHAINS_H_
