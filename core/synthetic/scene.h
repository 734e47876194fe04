// A synthetic scene: cameras around an area and people moving in it, with the
// exact truth. For simulated detections see noise.h.
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
  double target_height_m = 0.9;  // target point, above the centre
  double arc_deg = 360.0;        // part of the ring in use
  int64_t width_px = 1280;
  int64_t height_px = 720;
  double focal_px = 800.0;
  std::vector<double> distortion;  // k1 k2 p1 p2 k3 of OpenCV; empty: none
  bool fisheye = false;            // OpenCV's fisheye model: k1 k2 k3 k4

  void Describe(OptionVisitor& visitor);
};

// Behaviour of simulated people.
struct CrowdOptions {
  double area_radius_m = 3.0;     // people walk inside; visitors also outside
  double walking_speed_ms = 1.1;  // mean over people
  double min_distance_m = 0.55;   // minimum distance of two people (centres)
  // Weights of the next action after standing, turning or sitting; `walking` is
  // also the probability of walking on without a stop.
  double walking = 0.55;
  double standing = 0.2;
  double turning = 0.1;
  double sitting = 0.15;
  double arm_motion = 0.3;  // share of time with a gesture
  double visitors = 0.3;    // share of people who come and go
  double crossing = 0.7;    // share of walks through the centre

  void Describe(OptionVisitor& visitor);
};

// The configuration's table [scene].
struct SceneOptions {
  int64_t seed = 1;
  int64_t people = 4;
  double duration_s = 20.0;
  double frame_rate_hz = 25.0;
  std::string skeleton = "coco17";
  double stature_m = 1.72;        // mean
  double stature_sigma_m = 0.09;  // over people
  // Rotation of thorax and head relative to the pelvis; 1: as in real people.
  // At 0 every bone of every skeleton keeps its length; otherwise bones across
  // the spine or the neck (shoulder to hip, ear to shoulder) vary by
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

// Properties of a person besides the poses.
struct ActorFacts {
  double stature_m = 0.0;         // estimated for recorded motion
  std::vector<TimeSpan> present;  // in the scene
  std::vector<TimeSpan> seated;
  std::string clip;  // file of the recorded motion; empty: simulated
  TrackId clip_id;   // of the person in that file
};

// A person, simulated or recorded: a pure function of time, so that any camera
// may sample any moment. Times are the scene's [s], positions its world's [m].
class Actor {
 public:
  virtual ~Actor() = default;

  virtual bool PresentAt(double time_s) const = 0;
  // One entry per joint of the scene's skeleton. Call this and the two below
  // only while present.
  virtual Pose3d PoseAt(double time_s) const = 0;
  // Origin between the hips; x forward, y to the left, z along the spine.
  virtual SegmentPose TrunkAt(double time_s) const = 0;
  // The body as an occluder.
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

// Motion is defined for this time before and after the scene [s]; limits clock
// offsets and jitter.
inline constexpr double kSceneMargin = 2.0;

// Throws OptionError for options outside their limits, an unknown skeleton or
// joint, or cameras less than half a metre from where people may be.
Scene MakeScene(const SceneOptions& options);
// Overload with a given skeleton; `options.skeleton` is ignored.
Scene MakeScene(const SceneOptions& options, const Skeleton& skeleton);
// Overload with given people (recorded_people.h) instead of simulated ones: of
// `options` only cameras, duration and frame rate are used. Throws
// OptionError("clips", ...) if a person comes within half a metre of a camera.
Scene MakeScene(const SceneOptions& options, const Skeleton& skeleton,
                std::vector<std::shared_ptr<const Actor>> people);

CameraRig MakeRing(const RingOptions& options);

// Pose of a person at any moment of the scene; empty while absent.
Pose3d PersonAt(const Actor& person, TimeNs time);

// A person of the scene at one moment.
struct PersonMoment {
  Pose3d pose;                       // empty: absent
  std::optional<Obstacle> obstacle;  // if occlusion matters
};
struct SceneMoment {
  TimeNs time = 0;
  std::vector<PersonMoment> people;
};

// All people at `time`, with their obstacles if wanted (expensive to compute).
SceneMoment LookAtScene(const Scene& scene, TimeNs time, bool with_obstacles);

bool IsInImage(const Camera& camera, const Eigen::Vector2d& px);

// One joint as a camera sees it.
struct JointSight {
  bool in_image = false;
  bool hidden = false;                           // by another body
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // exact
  double depth_m = 1.0;
};

// One person as a camera sees them in one frame.
struct PersonSight {
  bool present = false;  // in the scene
  std::vector<JointSight> joints;
};

// Each person as the camera sees them, without any error of a detector.
std::vector<PersonSight> Sights(const Camera& camera, const SceneMoment& moment,
                                int joint_count);

// The truth as tracks: all joints observed, person i has id i.
TrackSequence TruthOf(const Scene& scene);
// The truth at the frames and times of the detections.
TrackSequence TruthFor(const Scene& scene, const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_SCENE_H_
