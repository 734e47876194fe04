#include "solvers/scene/frame_faults.h"

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/evaluation/statistics.h"
#include "solvers/scene/doctor_words.h"

namespace kinegraph {
namespace {

// Share of the joints that lie elsewhere in the other picture; nullopt where
// the pictures show other people.
std::optional<double> ChangedShare(const ViewDetections& a,
                                   const ViewDetections& b) {
  if (a.detections.empty() || a.detections.size() != b.detections.size()) {
    return std::nullopt;
  }
  double changed = 0.0;
  double all = 0.0;
  for (size_t d = 0; d < a.detections.size(); ++d) {
    const auto& one = a.detections[d].joints;
    const auto& other = b.detections[d].joints;
    for (size_t j = 0; j < one.size(); ++j) {
      if (!one[j].found && !other[j].found) continue;
      all += 1.0;
      changed +=
          one[j].found != other[j].found || one[j].px != other[j].px ? 1 : 0;
    }
  }
  if (all == 0.0) return std::nullopt;
  return changed / all;
}

// Pictures that come twice: a detector says the same to the last digit. Where
// detections are whole pixels and people stand, that is so by chance: the
// picture before must have differed in nearly every joint.
void LookForRepeats(const DoctorInput& input, size_t view,
                    std::vector<Finding>* findings) {
  const std::vector<DetectionFrame>& frames = input.detections.frames;
  constexpr double kMoving = 0.8;
  constexpr double kLeastShare = 0.01;
  int64_t repeats = 0;
  int64_t pairs = 0;
  int64_t first = -1;
  double last_change = 0.0;
  for (size_t k = 1; k < frames.size(); ++k) {
    const auto change =
        ChangedShare(frames[k - 1].views[view], frames[k].views[view]);
    if (!change.has_value()) continue;
    ++pairs;
    if (*change > 0.0) {
      last_change = *change;
    } else if (last_change >= kMoving) {
      if (first < 0) first = frames[k].frame;
      ++repeats;
    }
  }
  if (repeats == 0 ||
      static_cast<double>(repeats) < kLeastShare * static_cast<double>(pairs)) {
    return;
  }
  findings->push_back(
      {"frames", input.cameras[view].name(), 0.9, 0.0, 0.0,
       "take the repeated pictures out, or give the view's own rate "
       "(input.view_frame_rate)",
       Format("%.0f of %.0f pictures repeat the one before, the first in "
              "frame %.0f",
              static_cast<double>(repeats), static_cast<double>(pairs),
              static_cast<double>(first))});
}

}  // namespace

std::vector<Finding> FindFrameFaults(const DoctorInput& input) {
  const std::vector<DetectionFrame>& frames = input.detections.frames;
  std::vector<Finding> findings;
  std::vector<double> gaps;
  for (size_t k = 1; k < frames.size(); ++k) {
    gaps.push_back(ToSeconds(frames[k].time - frames[k - 1].time));
  }
  if (gaps.empty()) return findings;
  const double gap_s = Quantile(gaps, 0.5);
  // Nothing that people do can be followed over a second.
  constexpr double kLongestGapS = 1.0;
  if (gap_s > kLongestGapS) {
    findings.push_back(
        {"frame_rate", "", 0.95, 0.0, 0.0,
         "--set=input.independent_frames=true, or the right "
         "input.frame_rate",
         Format("%.3g s lie between two frames: nothing there is motion",
                gap_s)});
  }
  for (size_t v = 0; v < input.cameras.size(); ++v) {
    LookForRepeats(input, v, &findings);
  }
  return findings;
}

}  // namespace kinegraph
