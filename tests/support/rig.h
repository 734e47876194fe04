// A ring of cameras, a standing person, and exact detections of people.
#ifndef KINEGRAPH_TESTS_SUPPORT_RIG_H_
#define KINEGRAPH_TESTS_SUPPORT_RIG_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "core/data/detection.h"
#include "core/data/observation.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph::testing {

// `count` cameras (focal length 1000 px, 1920 x 1080 px) evenly on a circle of
// `radius_m` around the z axis at a height of 2 m, looking at (0, 0, 1) m.
// `distortion`: k1 k2 p1 p2 k3, as MakeLens takes them for "opencv5".
CameraRig RingOfCameras(int count, double radius_m = 5.0,
                        const std::vector<double>& distortion = {});

// A person in COCO-17 standing at (x, y), facing +y, all joints observed.
Pose3d StandingPerson(double x_m, double y_m);

// The exact projection of a pose into a camera, with confidence 1; missing
// joints and joints without an image (behind the camera) are not found.
Detection Project(const Pose3d& pose, const Camera& camera);

// The exact detections of these people in all cameras.
DetectionFrame FrameSeenBy(const CameraRig& rig, int64_t frame,
                           const std::vector<Pose3d>& people,
                           double rate_hz = 25.0);

// The exact detections, at 25 Hz in COCO-17, of the people that `people`
// returns for each frame.
DetectionSequence SeenBy(const CameraRig& rig, int frames,
                         const std::function<std::vector<Pose3d>(int)>& people);

// The exact projection of a pose into view `view_idx`, as an observation for
// triangulation.
Observation Observe(const Pose3d& pose, const CameraRig& cameras, int view_idx,
                    int detection_idx = 0);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_RIG_H_
