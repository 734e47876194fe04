// Cheap questions about single views, asked before anything is asked of cameras
// or clocks: what they explain is applied first.
#ifndef KINEGRAPH_SOLVERS_SCENE_VIEW_CHECKS_H_
#define KINEGRAPH_SOLVERS_SCENE_VIEW_CHECKS_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {

// Frames in which a view shows anybody.
struct ShownFrames {
  int64_t first = 0;
  int64_t last = 0;
  bool any = false;
};
std::vector<ShownFrames> FramesShown(const DetectionSequence& detections);

// What is to be taken from each view's frame numbers so that all views have
// frames in common: nothing (0) but of those that share no frame with most
// others. Empty where all share some.
std::vector<int64_t> FrameOffsets(const std::vector<ShownFrames>& shown);
DetectionSequence WithFrameOffsets(const DetectionSequence& detections,
                                   const std::vector<int64_t>& offsets);

// A view whose files count frames at another rate than the rest.
struct OtherRate {
  size_t view = 0;
  double rate_hz = 0.0;
  double offset = 0.0;  // that its numbers are too high by
  AgreementGain gain;   // with the others
};
// `people` in ideal pixels, one entry a frame of `detections`.
std::optional<OtherRate> FindOtherRate(const CameraRig& cameras,
                                       const std::vector<ViewPeople>& people,
                                       const DetectionSequence& detections,
                                       double frame_rate_hz);
DetectionSequence WithViewRate(const DetectionSequence& detections, size_t view,
                               double factor, double offset);

// Views whose left and right are exchanged.
struct ExchangedSides {
  std::vector<char> views;
  AgreementGain gain;  // of the pairs of views that change
  // People whose nose and toes point backwards as all views state them, of
  // those that were looked at.
  int backwards = 0;
  int looked_at = 0;
};
std::optional<ExchangedSides> FindExchangedSides(
    const CameraRig& cameras, const std::vector<ViewPeople>& people,
    const std::vector<int>& frames, const Skeleton& skeleton);
void ExchangeSides(const std::vector<char>& views,
                   DetectionSequence* detections);

// A view whose video was scaled or cropped before people were detected: pixel
// of the detections = scale * pixel of the camera - offset.
struct OtherImage {
  size_t view = 0;
  double scale = 1.0;
  Eigen::Vector2d offset_px = Eigen::Vector2d::Zero();
  AgreementGain gain;  // with the others
  bool scaled() const { return scale != 1.0; }
  bool cropped() const { return !offset_px.isZero(); }
};
// `raw` in the detections' own pixels; lenses are those of the cameras.
std::optional<OtherImage> FindOtherImage(const CameraRig& cameras,
                                         const std::vector<ViewPeople>& raw,
                                         const std::vector<int>& frames);
Camera WithImage(const Camera& camera, const OtherImage& image);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_VIEW_CHECKS_H_
