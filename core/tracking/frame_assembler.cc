#include "core/tracking/frame_assembler.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

namespace kinegraph {

void FrameAssembler::BeginFrame(int64_t frame, TimeNs time) {
  CHECK(open_.empty() || open_.back().content.frame < frame);
  OpenFrame& opened = open_.emplace_back();
  opened.content.frame = frame;
  opened.content.time = time;
}

void FrameAssembler::Resolve(int64_t frame, PersonPose* person) {
  const auto at = std::lower_bound(
      open_.begin(), open_.end(), frame,
      [](const OpenFrame& o, int64_t f) { return o.content.frame < f; });
  CHECK(at != open_.end() && at->content.frame == frame && at->waiting > 0);
  --at->waiting;
  if (person != nullptr) at->content.people.push_back(std::move(*person));
}

void FrameAssembler::ExtractComplete(std::vector<TrackFrame>* frames) {
  while (!open_.empty() && open_.front().waiting == 0) {
    TrackFrame& frame = open_.front().content;
    std::sort(
        frame.people.begin(), frame.people.end(),
        [](const PersonPose& a, const PersonPose& b) { return a.id < b.id; });
    frames->push_back(std::move(frame));
    open_.pop_front();
  }
}

}  // namespace kinegraph
