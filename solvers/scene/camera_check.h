// A cheap look at a finished run: does each camera see people where, and when,
// the others do? For warnings at the end of `track`; the doctor says more.
#ifndef KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_
#define KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/base/weighted_quantile.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Does each camera see people when the others do? A view whose pictures are
// taken later sees them farther on: by their speed in the image times how much
// later.
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

// One camera that is off, in a sentence that names it.
struct CameraWarning {
  enum class Kind {
    kHardlySeen,  // people are hardly found where the others put them
    kElsewhere,   // people are seen beside where the others put them
    kOffBeat,     // they are seen as if pictures were taken earlier or later
  };
  Kind kind;
  std::string text;
};

class CameraCheck {
 public:
  // Cameras in the order of the views; skeletons of detections and tracks.
  CameraCheck(CameraRig cameras, const Skeleton& detections,
              const Skeleton& tracks);

  // Looks at the world in a metre that is so long (SubjectScale), before the
  // first tracks with people.
  void set_metre(double metre);
  // Frames as the tracker is fed, ascending. Keeps some: every second one of
  // the first 400, every fourth of the next 800, and so on; each counts for
  // those between, so that all parts of a recording count alike.
  void SeeDetections(const DetectionFrame& frame);
  // Frames that were written, ascending.
  void SeeTracks(const TrackFrame& frame);

  struct View {
    int64_t people = 0;  // written people whose place the view shows
    int64_t seen = 0;    // of them, with a detection near by
    // Of detection less the projection of what the other views triangulate; of
    // two views alone, across the epipolar line of the other.
    double median_x_px = 0.0;
    double median_y_px = 0.0;
    double px_per_m = 0.0;  // at the people's depth
    ClockCheck::View clock;
  };
  std::vector<View> Views() const;
  // Of each camera that is off; empty when all is well or too little was seen.
  std::vector<CameraWarning> Warnings() const;

 private:
  bool is_pair() const { return cameras_.size() == 2; }
  static constexpr size_t kFramesAStride = 200;
  // From so many on the scale of confidences is known.
  static constexpr size_t kConfidences = 2000;

  struct Residuals {
    int64_t people = 0;
    int64_t seen = 0;
    int64_t tried = 0;                // joints that were to be triangulated
    std::vector<WeightedValue> x_px;  // of those that could be

    std::vector<WeightedValue> y_px;
    double px_per_m = 0.0;
  };
  struct KeptFrame {
    DetectionFrame frame;
    double weight = 1.0;  // how many frames it stands for
  };

  void Compare(const KeptFrame& kept, const PersonPose& person);
  const Detection* NearestTo(const ViewDetections& view, const Camera& camera,
                             const PersonPose& person) const;
  void AddResiduals(const KeptFrame& kept, const PersonPose& person,
                    const std::vector<const Detection*>& seen, size_t v);

  CameraRig cameras_;
  std::vector<int> track_joint_;  // of a detection's joint, or -1
  ClockCheck clocks_;
  double metre_ = 1.0;
  int64_t frames_fed_ = 0;
  int64_t stride_ = 2;
  size_t frames_kept_ = 0;
  std::vector<double> confidences_;  // of the first joints
  double confidence_scale_ = 1.0;
  std::map<int64_t, KeptFrame> waiting_;
  std::vector<Residuals> views_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_
