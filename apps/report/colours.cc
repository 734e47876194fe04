#include "apps/report/colours.h"

#include <algorithm>
#include <cstdint>
#include <optional>

namespace kinegraph {

Colours::Colours(const TrackSequence& tracks, const TrackSequence* lead,
                 const Colours* lead_colours) {
  std::map<TrackId, std::map<TrackId, int>> votes;
  if (lead != nullptr) votes = Votes(tracks, *lead);
  int next = lead_colours == nullptr
                 ? 0
                 : static_cast<int>(lead_colours->colour_.size());
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      if (colour_.count(person.id) > 0) continue;
      ids_.push_back(person.id);
      const auto& of_person = votes[person.id];
      const auto best = std::max_element(
          of_person.begin(), of_person.end(),
          [](const auto& a, const auto& b) { return a.second < b.second; });
      colour_[person.id] = lead_colours == nullptr || best == of_person.end()
                               ? next++
                               : lead_colours->colour_.at(best->first);
    }
  }
}

std::map<TrackId, std::map<TrackId, int>> Colours::Votes(
    const TrackSequence& tracks, const TrackSequence& lead) {
  constexpr double kGateM = 0.5;  // two people are hardly nearer
  std::map<int64_t, const TrackFrame*> lead_frames;
  for (const TrackFrame& frame : lead.frames) lead_frames[frame.frame] = &frame;
  std::map<TrackId, std::map<TrackId, int>> votes;
  for (const TrackFrame& frame : tracks.frames) {
    const auto at = lead_frames.find(frame.frame);
    if (at == lead_frames.end()) continue;
    for (const PersonPose& person : frame.people) {
      const auto here = MeanPosition(person.joints);
      double nearest = kGateM;
      std::optional<TrackId> same;
      for (const PersonPose& other : at->second->people) {
        const auto there = MeanPosition(other.joints);
        if (!here.has_value() || !there.has_value()) continue;
        const double distance = (*here - *there).norm();
        if (distance >= nearest) continue;
        nearest = distance;
        same = other.id;
      }
      if (same.has_value()) ++votes[person.id][*same];
    }
  }
  return votes;
}

}  // namespace kinegraph
