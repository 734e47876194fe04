#include "core/synthetic/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/synthetic/crowd.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// cam_from_world rotation of a camera at `centre` that looks at `target`; the
// world's z is up in the image.
Matrix3d LookAt(const Vector3d& centre, const Vector3d& target) {
  const Vector3d z = (target - centre).normalized();
  const Vector3d x = z.cross(Vector3d::UnitZ()).normalized();
  Matrix3d R;
  R << x.transpose(), z.cross(x).transpose(), z.transpose();
  return R;
}

void CheckCamerasOutside(const SceneOptions& options) {
  constexpr double kClearance = 0.5;
  const double least = options.motion.area_radius_m + kOuterMargin + kClearance;
  if (options.cameras.radius_m < least) {
    std::ostringstream message;
    message << "found " << options.cameras.radius_m << ", expected at least "
            << least << ": people come as far as " << least - kClearance
            << " m";
    throw OptionError("cameras.radius", message.str());
  }
}

const Skeleton& SkeletonNamed(const std::string& name) {
  const Skeleton* skeleton = FindSkeleton(name);
  if (skeleton != nullptr) return *skeleton;
  std::string known;
  for (const std::string& other : SkeletonNames()) {
    known += (known.empty() ? "" : ", ") + other;
  }
  throw OptionError(
      "skeleton", "found '" + Printable(name) + "', expected one of " + known);
}

using People = std::vector<std::shared_ptr<const Actor>>;

Scene FilledScene(const SceneOptions& options, const Skeleton& skeleton,
                  People people) {
  Scene scene;
  scene.cameras = MakeRing(options.cameras);
  scene.skeleton = skeleton;
  scene.frame_rate_hz = options.frame_rate_hz;
  scene.people = std::move(people);
  const FrameClock clock(options.frame_rate_hz);
  const auto frames = std::max<int64_t>(
      1, std::llround(options.duration_s * options.frame_rate_hz));
  for (int64_t frame = 0; frame < frames; ++frame) {
    scene.times.push_back(clock.TimeOf(frame));
    std::vector<Pose3d> poses;
    for (const auto& person : scene.people) {
      poses.push_back(PersonAt(*person, scene.times.back()));
    }
    scene.poses.push_back(std::move(poses));
  }
  return scene;
}

void CheckPeopleOffCameras(const Scene& scene) {
  constexpr double kClearance = 0.5;  // [m]
  for (size_t f = 0; f < scene.poses.size(); ++f) {
    for (size_t i = 0; i < scene.people.size(); ++i) {
      for (const Joint3d& joint : scene.poses[f][i]) {
        for (const Camera& camera : scene.cameras) {
          if ((joint.position_m - camera.centre()).norm() >= kClearance) {
            continue;
          }
          throw OptionError(
              "clips", scene.people[i]->Facts().clip +
                           ": a person comes nearer than half a metre to "
                           "camera '" +
                           camera.name() + "' at " +
                           std::to_string(ToSeconds(scene.times[f])) +
                           " s; raise scene.cameras.radius or move the clip "
                           "(motion.x, motion.y)");
        }
      }
    }
  }
}

}  // namespace

void RingOptions::Describe(OptionVisitor& visitor) {
  visitor.Integer("count", &count, Between(2, 32), "", "number of cameras");
  visitor.Number("radius", &radius_m, Between(1.0, 1000.0), "m",
                 "radius of the ring on which the cameras stand");
  visitor.Number("height", &height_m, Between(0.0, 100.0), "m",
                 "height of the cameras above the floor");
  visitor.Number(
      "target_height", &target_height_m, Between(0.0, 10.0), "m",
      "height of the point above the centre at which the cameras look");
  visitor.Number("arc", &arc_deg, Between(10.0, 360.0), "deg",
                 "part of the ring that is used");
  visitor.Integer("image_width", &width_px, Between(16, 16384), "px",
                  "width of the images");
  visitor.Integer("image_height", &height_px, Between(16, 16384), "px",
                  "height of the images");
  visitor.Number("focal", &focal_px, Positive(), "px", "focal length");
  visitor.NumberList("distortion", &distortion, Between(-10.0, 10.0), "",
                     "k1 k2 p1 p2 k3 of OpenCV's model; empty: none");
  visitor.Boolean("fisheye", &fisheye,
                  "the lenses are OpenCV's fisheye model: k1 k2 k3 k4");
}

void CrowdOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("area_radius", &area_radius_m, Between(1.0, 100.0), "m",
                 "people walk inside this circle");
  visitor.Number("walking_speed", &walking_speed_ms, Between(0.3, 2.0), "m/s",
                 "mean walking speed over people");
  visitor.Number("min_distance", &min_distance_m, Between(0.3, 2.0), "m",
                 "minimum distance between the centres of two people");
  visitor.Number("walking", &walking, Between(0.0, 1.0), "",
                 "weight of walking as the next action; probability of walking "
                 "on without a stop");
  visitor.Number("standing", &standing, Between(0.0, 1.0), "",
                 "weight of standing as the next action");
  visitor.Number("turning", &turning, Between(0.0, 1.0), "",
                 "weight of turning on the spot");
  visitor.Number("sitting", &sitting, Between(0.0, 1.0), "",
                 "weight of sitting down");
  visitor.Number("arm_motion", &arm_motion, Between(0.0, 0.95), "",
                 "share of time with a gesture");
  visitor.Number("visitors", &visitors, Between(0.0, 1.0), "",
                 "share of people who come and go");
  visitor.Number("crossing", &crossing, Between(0.0, 1.0), "",
                 "share of walks through the centre");
}

void SceneOptions::Describe(OptionVisitor& visitor) {
  visitor.Integer("seed", &seed, Between(0, 9e15), "", "same seed, same scene");
  visitor.Integer("people", &people, Between(1, 100), "", "number of people");
  visitor.Number("duration", &duration_s, Between(0.04, 36000.0), "s",
                 "length of the recording");
  visitor.Number("frame_rate", &frame_rate_hz, Between(1.0, 1000.0), "Hz",
                 "frames per second");
  visitor.Text("skeleton", &skeleton,
               "name of a skeleton: built-in, or in [skeletons.NAME]");
  visitor.Number("stature", &stature_m, Between(1.2, 2.2), "m",
                 "mean height of the people");
  visitor.Number("stature_sigma", &stature_sigma_m, Between(0.0, 0.15), "m",
                 "standard deviation of the people's heights");
  visitor.Number("trunk_flexibility", &trunk_flexibility, Between(0.0, 2.0), "",
                 "rotation of thorax and head relative to the pelvis; 0: trunk "
                 "and head are rigid; 1: as in real people");
  visitor.Table("motion", &motion);
  visitor.Table("cameras", &cameras);
}

CameraRig MakeRing(const RingOptions& options) {
  CheckOptions(options);
  CameraRig rig;
  const auto lens =
      MakeLens(options.fisheye ? kFisheyeModel : "opencv5", options.distortion);
  // Opposite cameras cannot determine depth, so the cameras of a pair (count 2)
  // are at most a right angle apart.
  const double arc = options.arc_deg * kPi / 180.0;
  const bool closed = options.arc_deg >= 360.0;
  const auto gaps =
      static_cast<double>(closed ? options.count : options.count - 1);
  const double spacing =
      options.count == 2 ? std::min(arc / gaps, 0.5 * kPi) : arc / gaps;
  for (int64_t i = 0; i < options.count; ++i) {
    const double angle = spacing * static_cast<double>(i);
    const Vector3d centre(options.radius_m * std::cos(angle),
                          options.radius_m * std::sin(angle), options.height_m);
    CameraParameters camera;
    camera.name = "cam" + std::to_string(i);
    camera.width_px = static_cast<int>(options.width_px);
    camera.height_px = static_cast<int>(options.height_px);
    camera.K << options.focal_px, 0.0,
        0.5 * static_cast<double>(options.width_px), 0.0, options.focal_px,
        0.5 * static_cast<double>(options.height_px), 0.0, 0.0, 1.0;
    camera.lens = lens;
    camera.R = LookAt(centre, {0.0, 0.0, options.target_height_m});
    camera.t = -camera.R * centre;
    rig.emplace_back(std::move(camera));
  }
  return rig;
}

Scene MakeScene(const SceneOptions& options) {
  return MakeScene(options, SkeletonNamed(options.skeleton));
}

Scene MakeScene(const SceneOptions& options, const Skeleton& skeleton) {
  CheckOptions(options);
  CheckCamerasOutside(options);
  return FilledScene(options, skeleton, SimulatePeople(options, skeleton));
}

Scene MakeScene(const SceneOptions& options, const Skeleton& skeleton,
                std::vector<std::shared_ptr<const Actor>> people) {
  CheckOptions(options);
  Scene scene = FilledScene(options, skeleton, std::move(people));
  CheckPeopleOffCameras(scene);
  return scene;
}

Pose3d PersonAt(const Actor& person, TimeNs time) {
  const double time_s = ToSeconds(time);
  if (!person.PresentAt(time_s)) return {};
  return person.PoseAt(time_s);
}

SceneMoment LookAtScene(const Scene& scene, TimeNs time, bool with_obstacles) {
  SceneMoment moment;
  moment.time = time;
  for (const auto& person : scene.people) {
    PersonMoment& now = moment.people.emplace_back();
    now.pose = PersonAt(*person, time);
    if (now.pose.empty()) continue;
    if (with_obstacles) now.obstacle = person->ObstacleAt(ToSeconds(time));
  }
  return moment;
}

bool IsInImage(const Camera& camera, const Vector2d& px) {
  return px.x() >= 0.0 && px.y() >= 0.0 && px.x() < camera.width_px() &&
         px.y() < camera.height_px();
}

std::vector<PersonSight> Sights(const Camera& camera, const SceneMoment& moment,
                                int joint_count) {
  std::vector<PersonSight> sights(moment.people.size());
  for (size_t i = 0; i < sights.size(); ++i) {
    const PersonMoment& person = moment.people[i];
    PersonSight& sight = sights[i];
    sight.joints.resize(static_cast<size_t>(joint_count));
    sight.present = !person.pose.empty();
    if (!sight.present) continue;
    for (int j = 0; j < joint_count; ++j) {
      JointSight& joint = sight.joints[j];
      const Vector3d& point = person.pose[j].position_m;
      const std::optional<Vector2d> px = camera.Project(point);
      joint.in_image = px.has_value() && IsInImage(camera, *px);
      if (!joint.in_image) continue;
      joint.px = *px;
      joint.depth_m = camera.Depth(point);
      for (size_t k = 0; k < moment.people.size() && !joint.hidden; ++k) {
        const std::optional<Obstacle>& body = moment.people[k].obstacle;
        joint.hidden =
            k != i && body.has_value() && body->Hides(camera.centre(), point);
      }
    }
  }
  return sights;
}

TrackSequence TruthOf(const Scene& scene) {
  DetectionSequence nothing_seen;
  for (size_t i = 0; i < scene.times.size(); ++i) {
    DetectionFrame& frame = nothing_seen.frames.emplace_back();
    frame.frame = static_cast<int64_t>(i);
    frame.time = scene.times[i];
  }
  return TruthFor(scene, nothing_seen);
}

TrackSequence TruthFor(const Scene& scene,
                       const DetectionSequence& detections) {
  TrackSequence truth;
  truth.header.skeleton = scene.skeleton;
  truth.header.mode = "truth";
  truth.header.frame_rate_hz = scene.frame_rate_hz;
  for (const Camera& camera : scene.cameras) {
    truth.header.view_names.push_back(camera.name());
  }
  for (const DetectionFrame& at : detections.frames) {
    TrackFrame& frame = truth.frames.emplace_back();
    frame.frame = at.frame;
    frame.time = at.time;
    for (size_t i = 0; i < scene.people.size(); ++i) {
      Pose3d pose = PersonAt(*scene.people[i], at.time);
      if (pose.empty()) continue;
      PersonPose& person = frame.people.emplace_back();
      person.id = TrackId(static_cast<int64_t>(i));
      person.inlier_views.assign(pose.size(),
                                 static_cast<int>(scene.cameras.size()));
      person.joints = std::move(pose);
      person.score = 1.0;
    }
  }
  return truth;
}

}  // namespace kinegraph
