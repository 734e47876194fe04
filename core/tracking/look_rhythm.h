// How often a detector looks.
#ifndef KINEGRAPH_CORE_TRACKING_LOOK_RHYTHM_H_
#define KINEGRAPH_CORE_TRACKING_LOOK_RHYTHM_H_

#include <deque>

#include "core/base/time.h"
#include "core/data/detection.h"

namespace kinegraph {

bool ShowsSomebody(const DetectionFrame& frame);

// A detector may run in every third frame of a video, or a file of 120 Hz may
// hold what was detected at 30: frames in between show nobody in any view, and
// nobody is missed there. The times between frames that show somebody tell such
// frames from those in which everybody has gone.
class LookRhythm {
 public:
  explicit LookRhythm(const FrameClock& clock) : clock_(clock) {}

  // The next frame. Whether somebody would have been seen in it: a view shows
  // somebody, or none has for longer than the detector has lately paused.
  bool IsLook(const DetectionFrame& frame);

  // Usual time from one frame that shows somebody to the next [frames], 1 or
  // more: the third quartile of the last ones.
  double usual_frames() const { return usual_frames_; }
  // How many frames the newest one that shows somebody stands for: those since
  // the one before, but no more than usual.
  double newest_frames() const { return newest_frames_; }

 private:
  void Note(double frames);

  FrameClock clock_;
  bool begun_ = false;
  TimeNs last_ = 0;            // frame that showed somebody
  std::deque<double> pauses_;  // [frames], the newest last
  double usual_frames_ = 1.0;
  double newest_frames_ = 1.0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_LOOK_RHYTHM_H_
