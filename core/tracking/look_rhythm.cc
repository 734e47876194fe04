#include "core/tracking/look_rhythm.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace kinegraph {
namespace {

// So many pauses are remembered. Their third quartile is usual: of a detector
// that leaves out every third frame half are 2 frames long, while holes in a
// recording are few.
constexpr size_t kRemembered = 15;
// With fewer pauses known no frame without anybody is taken for a miss.
constexpr size_t kEnough = 8;

}  // namespace

bool ShowsSomebody(const DetectionFrame& frame) {
  return std::any_of(
      frame.views.begin(), frame.views.end(),
      [](const ViewDetections& view) { return !view.detections.empty(); });
}

bool LookRhythm::IsLook(const DetectionFrame& frame) {
  const double frames = begun_ ? clock_.Frames(frame.time - last_) : 1.0;
  if (!ShowsSomebody(frame)) {
    return pauses_.size() >= kEnough &&
           frames > *std::max_element(pauses_.begin(), pauses_.end()) - 0.5;
  }
  if (begun_) Note(std::max(1.0, std::round(frames)));
  begun_ = true;
  last_ = frame.time;
  return true;
}

void LookRhythm::Note(double frames) {
  pauses_.push_back(frames);
  if (pauses_.size() > kRemembered) pauses_.pop_front();
  std::vector<double> sorted(pauses_.begin(), pauses_.end());
  const auto quartile =
      sorted.begin() + static_cast<long>(3 * sorted.size() / 4);
  std::nth_element(sorted.begin(), quartile, sorted.end());
  usual_frames_ = *quartile;
  newest_frames_ = std::min(frames, usual_frames_);
}

}  // namespace kinegraph
