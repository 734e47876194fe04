// A synthetic scene: cameras around an area and people moving in it, with the
// exact truth. What detectors make of it is the business of noise.h.
#ifndef KINEGRAPH_CORE_SYNTHETIC_SCENE_H_
#define KINEGRAPH_CORE_SYNTHETIC_SCENE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/base/time.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"
#include "core/synthetic/body.h"

namespace kinegraph {

// Cameras cam0, cam1, ... stand on a ring and look at its middle.
struct RingOptions {
  int64_t count = 5;
  double radius_m = 6.5;
  double height_m = 2.6;
  double target_height_m = 0.9;  // the point looked at, above the middle
  double arc_deg = 360.0;        // the ring's part that is used
  int64_t width_px = 1280;
  int64_t height_px = 720;
  double focal_px = 800.0;
  std::vector<double> distortion;  // k1 k2 p1 p2 k3 of OpenCV; empty: none
  bool fisheye = false;            // `distortion` is k1 k2 k3 k4 of its fisheye

  void Describe(OptionVisitor& visitor);
};

// What people do.
struct CrowdOptions {
  double area_radius_m = 3.0;     // people walk inside this circle
  double walking_speed_ms = 1.1;  // mean over people
  double min_distance_m = 0.55;   // closest that two people pass (centres)
  // After each walk the next deed is drawn with these weights.
  double walking = 0.55;
  double standing = 0.2;
  double turning = 0.1;
  double sitting = 0.15;
  double arm_motion = 0.3;  // share of time with a gesture
  double visitors = 0.3;    // share of people who come and go
  double crossing = 0.7;    // share of walks led through the middle

  void Describe(OptionVisitor& visitor);
};

// Table [scene].
struct SceneOptions {
  int64_t seed = 1;
  int64_t people = 4;
  double duration_s = 20.0;
  double frame_rate_hz = 25.0;
  std::string skeleton = "coco17";
  double stature_m = 1.72;        // mean
  double stature_sigma_m = 0.09;  // over people
  // Turning of thorax and head against the pelvis, as a share of what people
  // do. At 0 every bone of every skeleton keeps its length; else those that
  // cross the spine or the neck (shoulder to hip, ear to shoulder) breathe by
  // millimetres to centimetres, as in real people.
  double trunk_flexibility = 0.0;
  CrowdOptions motion;
  RingOptions cameras;

  void Describe(OptionVisitor& visitor);
};

struct TimeSpan {
  double begin_s = 0.0;
  double end_s = 0.0;
};

// What is told about a person beside the poses.
struct ActorFacts {
  double stature_m = 0.0;         // estimated where motion was recorded
  std::vector<TimeSpan> present;  // in the scene
  std::vector<TimeSpan> seated;
  std::string clip;  // file of the recorded motion; empty: simulated
  TrackId clip_id;   // the person's in that file
};

// A person, simulated or recorded: a pure function of time, so that any camera
// may sample any moment. Times are the scene's [s], positions its world's [m].
class Actor {
 public:
  virtual ~Actor() = default;

  virtual bool PresentAt(double time_s) const = 0;
  // One entry a joint of the scene's skeleton; asked only where present, as
  // the two below.
  virtual Pose3d PoseAt(double time_s) const = 0;
  // x forward, y to the left: what a detector calls the person's front.
  virtual SegmentPose TrunkAt(double time_s) const = 0;
  // The body as what hides others.
  virtual Obstacle ObstacleAt(double time_s) const = 0;

  virtual ActorFacts Facts() const = 0;
};

struct Scene {
  CameraRig cameras;
  Skeleton skeleton;
  double frame_rate_hz = 0.0;
  std::vector<TimeNs> times;  // of frames 0, 1, 2, ...
  std::vector<std::shared_ptr<const Actor>> people;
  // poses[frame][person]; empty while the person is not in the scene.
  std::vector<std::vector<Pose3d>> poses;
};

// How far outside the scene's time its motion is defined [s]: clock offsets and
// jitter may reach that far.
inline constexpr double kSceneMargin = 2.0;

// Throws OptionError for options outside their limits, an unknown skeleton or
// joint, or cameras inside the area.
Scene MakeScene(const SceneOptions& options);
// The same with a skeleton of one's own; `options.skeleton` is not looked at.
Scene MakeScene(const SceneOptions& options, const Skeleton& skeleton);
// The same with people of one's own (recorded ones, recorded_people.h) in place
// of simulated ones; of `options` the people, stature and motion are not looked
// at. Throws OptionError("clips", ...) when somebody comes so near to a camera
// that half a metre is not left.
Scene MakeScene(const SceneOptions& options, const Skeleton& skeleton,
                std::vector<std::shared_ptr<const Actor>> people);

CameraRig MakeRing(const RingOptions& options);

// Pose of a person at any moment of the scene; empty when not in it.
Pose3d PersonAt(const Actor& person, TimeNs time);

// A person of the scene at one moment.
struct PersonMoment {
  Pose3d pose;  // empty: not there, and what follows says nothing
  SegmentPose trunk;
  std::optional<Obstacle> obstacle;  // where hiding matters
};
struct SceneMoment {
  TimeNs time = 0;
  std::vector<PersonMoment> people;
};

// Everybody at `time`; obstacles are slow to place.
SceneMoment LookAtScene(const Scene& scene, TimeNs time, bool with_obstacles);

bool IsInImage(const Camera& camera, const Eigen::Vector2d& px);

// What the camera could see of one joint.
struct JointSight {
  bool in_image = false;
  bool hidden = false;                           // by another body
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // exact
  double depth_m = 1.0;
};

// Of one person in one frame.
struct PersonSight {
  bool present = false;      // in the scene
  double azimuth_deg = 0.0;  // of the camera, 0 in front, +90 to the right
  std::vector<JointSight> joints;
};

// What a camera sees of each person, before any fault of a detector.
std::vector<PersonSight> Sights(const Camera& camera, const SceneMoment& moment,
                                int joint_count);

// The truth as tracks: all joints observed, person i has id i.
TrackSequence TruthOf(const Scene& scene);
// The same at the frames and times that the detections tell.
TrackSequence TruthFor(const Scene& scene, const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_SCENE_H_
