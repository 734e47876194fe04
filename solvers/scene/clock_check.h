// A cheap look at a finished run: does each camera see people when the others
// do? A view whose pictures are taken later sees them farther on: by their
// speed in the image times how much later.
#ifndef KINEGRAPH_SOLVERS_SCENE_CLOCK_CHECK_H_
#define KINEGRAPH_SOLVERS_SCENE_CLOCK_CHECK_H_

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/base/weighted_quantile.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

class ClockCheck {
 public:
  explicit ClockCheck(CameraRig cameras);

  // A joint in one view, less where the other views alone put it.
  struct Sample {
    size_t view = 0;
    TimeNs time = 0;  // of the frame
    TrackId person;
    size_t joint = 0;  // of the tracks
    Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();
    double weight = 1.0;
    // How much later than the others' pictures the view's was taken, by the
    // times told [s].
    double told_late_s = 0.0;
  };
  void Add(const Sample& sample) { waiting_.push_back(sample); }
  // Every written frame, ascending, after the samples of it.
  void SeeTracks(const TrackFrame& frame);

  struct View {
    size_t samples = 0;    // joints in motion
    double late_s = 0.0;   // beyond what the times tell
    double error_m = 0.0;  // what that is where joints move
  };
  std::vector<View> Views() const;

  // What was written of a frame.
  struct Moment {
    TimeNs time = 0;
    std::vector<std::pair<TrackId, Pose3d>> people;
  };

 private:
  const Moment& NearestTo(TimeNs time) const;
  void Weigh(const Sample& sample);

  CameraRig cameras_;
  std::deque<Moment> recent_;
  std::deque<Sample> waiting_;
  struct Lateness {
    std::vector<WeightedValue> late_s;  // weighted by weight times speed^2
    double weight = 0.0;                // sums
    double squared_speed = 0.0;         // m^2/s^2, weighted
  };
  std::vector<Lateness> late_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CLOCK_CHECK_H_
