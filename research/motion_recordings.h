// Recorded motion, observed by synthetic cameras and a modelled detector with
// known association, as input for comparing smoothers.
#ifndef KINEGRAPH_RESEARCH_MOTION_RECORDINGS_H_
#define KINEGRAPH_RESEARCH_MOTION_RECORDINGS_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/tracking/replay.h"

namespace kinegraph::testing {

// One person's joints at a constant rate.
struct SteadyClip {
  Skeleton skeleton;
  double rate_hz = 0.0;
  std::vector<std::vector<Eigen::Vector3d>> joints_m;  // by frame and joint

  double seconds() const {
    return static_cast<double>(joints_m.size()) / rate_hz;
  }
};

// The first person of a tracks file of three or more frames, who must have all
// joints in each, moved so that the middle of the bounding box of all joints
// lies above the origin.
SteadyClip LoadSteadyClip(const std::string& path);

// The same motion at another rate, by a natural cubic spline per coordinate.
SteadyClip Resample(const SteadyClip& clip, double rate_hz);

// The first `seconds` of the clip, or all of it.
SteadyClip FirstSeconds(const SteadyClip& clip, double seconds);

// The first pose held for `seconds`, then the clip. While it is held, the body
// sways above its feet like that of a standing person, by a few millimetres at
// frequencies below 1 Hz, and comes to rest at the clip's first pose.
SteadyClip AfterRest(const SteadyClip& clip, double seconds);

// The clip with joint centres that are not points of rigid bones (joint_sway_m
// in core/synthetic/recorded_people.h).
SteadyClip WithJointSway(const SteadyClip& clip, double amplitude_m,
                         uint64_t seed);

// Errors that a detector adds to the exact projection of a joint.
struct DetectorModel {
  std::string name;
  double sigma_px = 0.0;            // per axis
  double correlation_time_s = 0.0;  // AR(1); 0: white
  double outliers = 0.0;            // fraction of the joints, independently
  double outlier_px = 40.0;  // distance of an outlier, in a random direction
  double missing = 0.0;      // fraction of the joints
};

// A ring of `count` cameras around the origin, 5 m away and 1.2 m high, focal
// length 1250 px: a pixel is 4 mm at the origin.
CameraRig MotionCameras(int count);

// The recording of one person, ready for estimators: after the joints filter
// and DLT.
struct MotionRecording {
  SceneModel scene;
  SteadyClip clip;  // the truth
  std::shared_ptr<const Replay> replay;
  ReplayedPerson person;
  // The clip's frame in which the person appears.
  int64_t first_frame = 0;
};

MotionRecording ObserveMotion(const SteadyClip& clip, const CameraRig& cameras,
                              const DetectorModel& detector, uint64_t seed);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_RESEARCH_MOTION_RECORDINGS_H_
