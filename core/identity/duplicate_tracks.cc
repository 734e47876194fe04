#include "core/identity/duplicate_tracks.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

namespace kinegraph {
namespace {

constexpr double kSamePlace = 0.35;  // m, people are never nearer for long
// Of a duplicate's frames at that place.
constexpr double kDuplicateShare = 0.8;

// Mean distance of the joints that both have [m].
std::optional<double> Distance(const Pose3d& a, const Pose3d& b) {
  double sum = 0.0;
  int count = 0;
  for (size_t j = 0; j < a.size(); ++j) {
    if (!a[j].present() || !b[j].present()) continue;
    sum += (a[j].position_m - b[j].position_m).norm();
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

struct Together {
  int64_t frames = 0;  // in which both are there
  int64_t same_place = 0;
  double distance_m = 0.0;  // mean over those at the same place
};

Together Compare(const Tracklet& a, const Tracklet& b) {
  Together together;
  size_t k = 0;
  for (const TrackletFrame& frame : a.frames) {
    while (k < b.frames.size() && b.frames[k].frame < frame.frame) ++k;
    if (k == b.frames.size()) break;
    if (b.frames[k].frame != frame.frame) continue;
    ++together.frames;
    const std::optional<double> distance_m =
        Distance(frame.pose->joints, b.frames[k].pose->joints);
    if (!distance_m.has_value() || *distance_m > kSamePlace) continue;
    ++together.same_place;
    together.distance_m += *distance_m;
  }
  if (together.same_place > 0) {
    together.distance_m /= static_cast<double>(together.same_place);
  }
  return together;
}

double Share(int64_t count, size_t of) {
  return static_cast<double>(count) / static_cast<double>(of);
}

}  // namespace

bool StandTogether(const Tracklet& a, const Tracklet& b) {
  const Together together = Compare(a, b);
  return together.frames > 0 &&
         Share(together.same_place, static_cast<size_t>(together.frames)) >=
             kDuplicateShare;
}

std::vector<IdentityEdit> FindDuplicates(const std::vector<Tracklet>& tracks) {
  std::vector<IdentityEdit> edits;
  for (size_t i = 0; i < tracks.size(); ++i) {
    for (size_t k = 0; k < tracks.size(); ++k) {
      const Tracklet& one = tracks[i];
      const Tracklet& other = tracks[k];
      const auto length = [](const Tracklet& t) { return t.frames.size(); };
      if (i == k || length(one) > length(other) ||
          (length(one) == length(other) && i < k)) {
        continue;
      }
      if (one.last().frame < other.first().frame ||
          other.last().frame < one.first().frame) {
        continue;
      }
      const Together together = Compare(one, other);
      const double share = Share(together.same_place, length(one));
      if (share < kDuplicateShare) continue;
      IdentityEdit edit;
      edit.op = EditOp::kDelete;
      edit.persons = {one.id};
      edit.frames = FrameSpan{one.first().frame, one.last().frame};
      edit.evidence = {{"double_of", static_cast<double>(other.id.value())},
                       {"share", share},
                       {"distance_m", together.distance_m}};
      edits.push_back(std::move(edit));
      break;
    }
  }
  return edits;
}

}  // namespace kinegraph
