// How a calibration may have been meant: the ways in which programs differ.
#ifndef KINEGRAPH_SOLVERS_SCENE_READINGS_H_
#define KINEGRAPH_SOLVERS_SCENE_READINGS_H_

#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {

// What the pose in the file is, if it was not read as it was meant.
enum class PoseReading {
  kAsRead,
  kInverse,           // it takes camera coordinates to the world
  kCentre,            // the translation is the camera's place in the world
  kTranslation,       // what was read as the camera's place is a translation
  kTransposed,        // rows of the rotation were columns
  kTransposedCentre,  // both
  kAxesUp,            // y up and z backwards in the camera, as in graphics
};
inline constexpr int kPoseReadingCount = 7;
const char* Describe(PoseReading reading);
// The camera that is meant where R and t, as they were read, mean that.
Camera WithPose(const Camera& camera, PoseReading reading);

// As the camera says, or twice its principal point [px].
double ImageWidth(const Camera& camera);
double ImageHeight(const Camera& camera);

// What was done to the images before people were detected in them.
enum class ImageReading {
  kAsRead,
  kRotated90,  // clockwise
  kRotated180,
  kRotated270,
  kMirrored,  // left and right exchanged
};
inline constexpr int kImageReadingCount = 5;
const char* Describe(ImageReading reading);
// The detections moved from the images as the detector was shown them back to
// the images as the cameras took them, which are `width_px` x `height_px`.
ViewPeople Restored(const ViewPeople& view, ImageReading reading,
                    double width_px, double height_px);
// The camera whose images are those that the detector was shown: with it the
// detections need not be moved. nullopt for mirrored images, which no camera
// takes.
std::optional<Camera> Seeing(const Camera& camera, ImageReading reading);

// One way to read everything: what is changed from the file's words.
struct Reading {
  PoseReading pose = PoseReading::kAsRead;
  double image_scale = 1.0;          // of K's first two rows
  std::vector<ImageReading> images;  // one a view
  std::vector<int> camera_of_view;   // permutation

  static Reading AsRead(size_t views);
  bool operator==(const Reading& other) const;
};

// What the views' cameras are under a reading (but
// for the images).
CameraRig CamerasOf(const CameraRig& cameras, const Reading& reading);
struct ReadingScore {
  Reading reading;
  PairAgreement agreement;  // over all views
  double score() const { return agreement.score(); }
};

struct ReadingSearch {
  ReadingScore as_read;
  // Readings that agree better by far and fit equally well; empty when the
  // calibration is read rightly as far as can be told. Best first.
  std::vector<ReadingScore> better;
};

// The reading under which the views agree. Changes one thing at a time, twice
// at most.
ReadingSearch SearchReadings(const CameraRig& cameras,
                             const std::vector<ViewPeople>& raw,
                             const std::vector<int>& frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_READINGS_H_
