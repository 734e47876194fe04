// How a calibration may have been meant: the ways in which programs differ, and
// a search for the one under which the views of a take agree.
#ifndef KINEGRAPH_SOLVERS_SCENE_READINGS_H_
#define KINEGRAPH_SOLVERS_SCENE_READINGS_H_

#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "solvers/scene/consistency.h"

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
// In place; R and t as they were read.
Camera WithPose(const Camera& camera, PoseReading reading);

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
// Pixels of the images as the cameras took them, from those of the images as
// they were shown to the detector. `width_px` and `height_px` are the camera's.
ViewPeople Restored(const ViewPeople& view, ImageReading reading,
                    double width_px, double height_px);
// A camera that sees the images as they were shown; nullopt for a mirror, which
// no camera is.
std::optional<Camera> Seeing(const Camera& camera, ImageReading reading);

// One way to read everything: what is changed from the file's words.
struct Reading {
  PoseReading pose = PoseReading::kAsRead;
  double image_scale = 1.0;  // of K's first two rows
  bool without_lens = false;
  std::vector<ImageReading> images;  // one a view
  std::vector<int> camera_of_view;   // permutation

  static Reading AsRead(size_t views);
  bool operator==(const Reading& other) const;
};

// Cameras of the views under a reading; a mirrored view keeps its camera.
CameraRig CamerasOf(const CameraRig& cameras, const Reading& reading);
// Its people in the ideal pixels of those cameras.
std::vector<ViewPeople> PeopleOf(const CameraRig& cameras,
                                 const std::vector<ViewPeople>& raw,
                                 const Reading& reading);

struct ReadingScore {
  Reading reading;
  double score = 0.0;  // PairAgreement::score over all views
  double distance_px = 0.0;
};

struct ReadingSearch {
  ReadingScore as_read;
  // Readings that agree better by far and fit equally well; empty when the
  // calibration is read rightly as far as can be told. Best first.
  std::vector<ReadingScore> better;
};

// Changes one thing at a time, twice at most.
ReadingSearch SearchReadings(const CameraRig& cameras,
                             const std::vector<ViewPeople>& raw,
                             const std::vector<int>& frames);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_READINGS_H_
