#include "core/identity/linking.h"

#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/identity/chain_edits.h"
#include "core/identity/chains.h"
#include "core/identity/duplicate_tracks.h"
#include "core/identity/edits.h"
#include "core/identity/false_positives.h"
#include "core/identity/tracklet.h"

namespace kinegraph {

void CheckLinkOptions(const LinkOptions& options) {
  CheckOptions(options);
  if (options.entries.size() % 4 == 0) return;
  throw OptionError("identity.entries",
                    "found " + std::to_string(options.entries.size()) +
                        " numbers, expected four a sphere: x, y, z, radius");
}

std::vector<IdentityEdit> LinkIdentities(
    const Skeleton& skeleton, double frame_rate_hz, const LinkOptions& options,
    std::vector<TrackFrame>* frames, std::vector<std::string>* left_out,
    const std::vector<Succession>& successions) {
  CheckLinkOptions(options);
  std::vector<IdentityEdit> edits;
  const auto apply = [&](std::vector<IdentityEdit> more) {
    for (std::string& line : ApplyEdits(std::move(more), frames, &edits)) {
      if (left_out != nullptr) left_out->push_back(std::move(line));
    }
  };
  if (frames->empty()) return edits;
  apply(FindDuplicates(CollectTracklets(*frames, skeleton)));
  apply(FindFalsePositives(skeleton, options.min_margin,
                           CollectTracklets(*frames, skeleton)));
  const std::vector<Tracklet> tracks = CollectTracklets(*frames, skeleton);
  if (tracks.empty()) return edits;
  apply(
      EditsOf(JoinPieces(skeleton, frame_rate_hz, options, tracks, successions),
              frames->back().frame));
  return edits;
}

}  // namespace kinegraph
