#include "solvers/session/take_clock.h"

#include <string>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// How much time passed where the clock does not tell.
constexpr TimeNs kUnknownPause = 1'000'000'000;

}  // namespace

bool TakeClock::Enter(DetectionFrame* frame) {
  const TimeNs time = frame->time;
  bool starts_anew = false;
  if (stretches_.empty()) {
    stretches_.push_back({frame->frame, 0});
  } else {
    if (frame->frame <= last_frame_) {
      throw InputError("frame " + std::to_string(frame->frame) +
                       " comes after frame " + std::to_string(last_frame_) +
                       ", expected frames to ascend");
    }
    starts_anew = time <= last_time_;
    if (starts_anew || time - last_time_ > longest_pause_) {
      const TimeNs pause = starts_anew ? kUnknownPause : longest_pause_;
      const TimeNs before = last_time_ + stretches_.back().put_on;
      stretches_.push_back({frame->frame, before + (pause - time)});
    }
  }
  last_frame_ = frame->frame;
  last_time_ = time;
  const TimeNs put_on = stretches_.back().put_on;
  frame->time += put_on;
  for (ViewDetections& view : frame->views) view.capture_time += put_on;
  return starts_anew;
}

void TakeClock::Leave(TrackFrame* frame) {
  while (stretches_.size() > 1 && stretches_[1].first_frame <= frame->frame) {
    stretches_.pop_front();
  }
  if (!stretches_.empty()) frame->time -= stretches_.front().put_on;
}

}  // namespace kinegraph
