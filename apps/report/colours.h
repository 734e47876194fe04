// Colours of the people on the page.
#ifndef KINEGRAPH_APPS_REPORT_COLOURS_H_
#define KINEGRAPH_APPS_REPORT_COLOURS_H_

#include <map>
#include <vector>

#include "core/data/pose.h"

namespace kinegraph {

// Colours by identity: 0, 1, 2 in order of first appearance; an identity of a
// later result takes the colour of the one that it is nearest to most often.
class Colours {
 public:
  // `lead` is null for the result that leads.
  Colours(const TrackSequence& tracks, const TrackSequence* lead,
          const Colours* lead_colours);

  const std::vector<TrackId>& ids() const { return ids_; }
  int ColourOf(TrackId id) const { return colour_.at(id); }

 private:
  static std::map<TrackId, std::map<TrackId, int>> Votes(
      const TrackSequence& tracks, const TrackSequence& lead);

  std::vector<TrackId> ids_;  // in order of first appearance
  std::map<TrackId, int> colour_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_COLOURS_H_
