// A cheap look at a finished run: does each camera see people where, and when,
// the others do? For warnings at the end of `track`; the doctor says more.
#ifndef KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_
#define KINEGRAPH_SOLVERS_SCENE_CAMERA_CHECK_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/weighted_quantile.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"
#include "solvers/scene/clock_check.h"

namespace kinegraph {

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
