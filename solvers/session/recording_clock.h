// The time of a run, which goes on whatever the recording's clock does.
#ifndef KINEGRAPH_SOLVERS_SESSION_RECORDING_CLOCK_H_
#define KINEGRAPH_SOLVERS_SESSION_RECORDING_CLOCK_H_

#include <cstdint>
#include <deque>

#include "core/base/time.h"
#include "core/data/detection.h"
#include "core/data/pose.h"

namespace kinegraph {

// A clock may be set while it records, stand, or pause for a year. Estimators
// get times that ascend, with pauses no longer than matters to any of them;
// what is written has the recording's own.
class RecordingClock {
 public:
  explicit RecordingClock(TimeNs longest_pause)
      : longest_pause_(longest_pause) {}

  // Puts the next frame on the run's time. True where the recording's clock
  // stood or stepped back: nobody lives on from the frames before. Throws
  // InputError, and stays as it was, when frame numbers do not ascend.
  bool Enter(DetectionFrame* frame);
  // Gives a frame its own time back; frames ascend, and earlier ones are
  // forgotten.
  void Leave(TrackFrame* frame);

 private:
  struct MotionSegment {
    int64_t first_frame = 0;
    TimeNs put_on = 0;  // by how much its times are later
  };

  const TimeNs longest_pause_;
  std::deque<MotionSegment> segments_;
  int64_t last_frame_ = 0;
  TimeNs last_time_ = 0;  // of the recording
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_RECORDING_CLOCK_H_
