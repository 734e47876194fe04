#include "solvers/session/recording_clock.h"

#include <string>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// How much time passed where the clock does not tell.
constexpr TimeNs kUnknownPause = 1'000'000'000;

}  // namespace

bool RecordingClock::Enter(DetectionFrame* frame) {
  const TimeNs time = frame->time;
  bool starts_anew = false;
  if (segments_.empty()) {
    segments_.push_back({frame->frame, 0});
  } else {
    if (frame->frame <= last_frame_) {
      throw InputError("frame " + std::to_string(frame->frame) +
                       " comes after frame " + std::to_string(last_frame_) +
                       ", expected frames to ascend");
    }
    starts_anew = time <= last_time_;
    if (starts_anew || time - last_time_ > longest_pause_) {
      const TimeNs pause = starts_anew ? kUnknownPause : longest_pause_;
      const TimeNs before = last_time_ + segments_.back().put_on;
      segments_.push_back({frame->frame, before + (pause - time)});
    }
  }
  last_frame_ = frame->frame;
  last_time_ = time;
  const TimeNs put_on = segments_.back().put_on;
  frame->time += put_on;
  for (ViewDetections& view : frame->views) view.capture_time += put_on;
  return starts_anew;
}

void RecordingClock::Leave(TrackFrame* frame) {
  while (segments_.size() > 1 && segments_[1].first_frame <= frame->frame) {
    segments_.pop_front();
  }
  if (!segments_.empty()) frame->time -= segments_.front().put_on;
}

}  // namespace kinegraph
