#include "tests/support/faulty_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/median.h"
#include "core/base/random.h"
#include "core/io/configuration/config.h"
#include "core/io/tracks/tracks.h"
#include "core/synthetic/recorded_people.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/session/options.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {

namespace {

Scene SceneOf(const SceneOptions& scene, const FaultySceneOptions& options) {
  if (options.clips.empty()) return MakeScene(scene);
  const Skeleton skeleton = ResolveSkeleton(scene.skeleton, {});
  std::vector<MotionClip> clips;
  for (const std::string& clip : options.clips) {
    clips.push_back({clip, ReadTracks(clip)});
  }
  RecordedPeopleOptions recorded;
  recorded.start_s = options.clip_start_s;
  return MakeScene(
      scene, skeleton,
      MakeRecordedPeople(recorded, clips, skeleton,
                         {scene.motion.area_radius_m,
                          scene.motion.min_distance_m, options.seed}));
}

// Observations with drifting clocks: the offsets change once per second.
DetectionSequence ObserveDrifting(const Scene& scene,
                                  const std::vector<double>& drift,
                                  NoiseOptions noise) {
  const std::vector<double> offset_s = noise.clock_offset_s;
  DetectionSequence result;
  bool more = true;
  for (int second = 0; more; ++second) {
    noise.clock_offset_s.assign(drift.size(), 0.0);
    for (size_t v = 0; v < drift.size(); ++v) {
      noise.clock_offset_s[v] =
          (v < offset_s.size() ? offset_s[v] : 0.0) + drift[v] * second;
    }
    DetectionSequence seen = Observe(scene, noise, nullptr);
    if (second == 0) result.header = seen.header;
    const auto end = std::min(
        seen.frames.size(),
        static_cast<size_t>(std::lround((second + 1) * scene.frame_rate_hz)));
    for (size_t k = result.frames.size(); k < end; ++k) {
      result.frames.push_back(std::move(seen.frames[k]));
    }
    more = end < seen.frames.size();
  }
  return result;
}

}  // namespace

FaultyScene MakeFaultyScene(const FaultySceneOptions& options) {
  SceneOptions scene;
  scene.seed = static_cast<int64_t>(options.seed);
  scene.people = options.people;
  scene.skeleton = options.skeleton;
  scene.duration_s = options.duration_s;
  scene.frame_rate_hz = options.frame_rate_hz;
  scene.motion.visitors = 0.0;
  scene.cameras.count = options.cameras;
  scene.cameras.arc_deg = options.arc_deg;
  scene.cameras.distortion = options.distortion;
  NoiseOptions noise;
  noise.seed = scene.seed + 1000;
  noise.joints.sigma_px = options.noise_px;
  noise.joints.outlier_rate = 0.02;
  noise.joints.missing_rate = 0.03;
  noise.clock_offset_s = options.clock_offset_s;
  noise.tell_times = false;
  FaultyScene result;
  result.scene = SceneOf(scene, options);
  // Real rigs are uneven: each camera is moved by up to 0.8 m along x and y and
  // 0.5 m along z.
  Random random(options.seed * 7919 + 13);
  for (Camera& camera : result.scene.cameras) {
    // Drawn in separate statements, because compilers evaluate arguments in
    // different orders.
    const double z = random.Uniform(-0.5, 0.5);
    const double y = random.Uniform(-0.8, 0.8);
    const double x = random.Uniform(-0.8, 0.8);
    const Eigen::Vector3d moved(x, y, z);
    camera = WithExtrinsics(camera, camera.R(),
                            -(camera.R() * (camera.centre() + moved)));
  }
  result.cameras = result.scene.cameras;
  result.detections =
      options.clock_drift.empty()
          ? Observe(result.scene, noise, nullptr)
          : ObserveDrifting(result.scene, options.clock_drift, noise);
  return result;
}

void AddLastingOffsets(uint64_t seed, double scale, FaultyScene* scene) {
  constexpr double kMedianM = 0.010;
  // Standard deviation of the logarithm: the 90th percentile, 1.28 sigma, is
  // at 35 mm = 3.5 medians; 0.98 is log(3.5) / 1.28.
  constexpr double kSigma = 0.98;
  Random random(seed);
  std::map<std::array<int64_t, 3>, Eigen::Vector2d> offsets_m;
  const auto offset_of = [&](int64_t person, size_t joint, size_t view) {
    const auto [at, is_new] = offsets_m.try_emplace(
        {person, static_cast<int64_t>(joint), static_cast<int64_t>(view)});
    if (is_new) {
      const double angle = random.Uniform(0.0, 2.0 * M_PI);
      const double length_m =
          scale * kMedianM * std::exp(kSigma * random.Normal());
      at->second = length_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    return at->second;
  };
  const TrackSequence truth = TruthOf(scene->scene);
  const std::vector<int> map =
      MapByName(scene->scene.skeleton, scene->detections.header.skeleton);
  for (size_t k = 0; k < truth.frames.size(); ++k) {
    for (size_t v = 0; v < scene->scene.cameras.size(); ++v) {
      const Camera& camera = scene->scene.cameras[v];
      for (Detection& one : scene->detections.frames[k].views[v].detections) {
        // The person whose joints are nearest to the detection.
        const PersonPose* person = nullptr;
        double nearest = 1e300;
        for (const PersonPose& pose : truth.frames[k].people) {
          std::vector<double> distances;
          for (size_t j = 0; j < one.joints.size(); ++j) {
            if (map[j] < 0 || !one.joints[j].found) continue;
            const auto px = camera.Project(
                pose.joints[static_cast<size_t>(map[j])].position_m);
            if (px) distances.push_back((*px - one.joints[j].px).norm());
          }
          if (distances.empty()) continue;
          const double distance = Median(std::move(distances));
          if (distance >= nearest) continue;
          nearest = distance;
          person = &pose;
        }
        if (person == nullptr) continue;
        for (size_t j = 0; j < one.joints.size(); ++j) {
          if (map[j] < 0 || !one.joints[j].found) continue;
          const double depth_m = camera.Depth(
              person->joints[static_cast<size_t>(map[j])].position_m);
          one.joints[j].px +=
              camera.focal_px() / depth_m * offset_of(person->id.value(), j, v);
        }
      }
    }
  }
}

Camera Turned(const Camera& camera, double degrees, uint64_t seed) {
  Random random(seed);
  const double z = random.Normal();
  const double y = random.Normal();
  const double x = random.Normal();
  const Eigen::Vector3d axis = Eigen::Vector3d(x, y, z).normalized();
  CameraChange change = CameraChange::Zero();
  change.segment<3>(kRotationAt) = degrees * M_PI / 180.0 * axis;
  return ChangedCamera(camera, change);
}

void ChangeJoints(FaultyScene* scene, size_t view,
                  const std::function<void(Keypoint*)>& change, size_t from) {
  auto& frames = scene->detections.frames;
  for (size_t k = from; k < frames.size(); ++k) {
    for (Detection& detection : frames[k].views[view].detections) {
      for (Keypoint& joint : detection.joints) change(&joint);
    }
  }
}

void TurnCameraFrom(size_t from, size_t v, double degrees, uint64_t seed,
                    FaultyScene* scene) {
  const Camera& before = scene->scene.cameras[v];
  const Camera after = Turned(before, degrees, seed);
  // A rotation about the camera's centre is a homography of pixels.
  const Eigen::Matrix3d moves =
      after.K() * after.R() * before.R().transpose() * before.K().inverse();
  ChangeJoints(
      scene, v,
      [&](Keypoint* joint) {
        joint->px = (moves * joint->px.homogeneous()).hnormalized();
      },
      from);
}

Camera Shifted(const Camera& camera, double x_px, double y_px) {
  CameraChange change = CameraChange::Zero();
  change[kShiftAt] = x_px;
  change[kShiftAt + 1] = y_px;
  return ChangedCamera(camera, change);
}

Camera Magnified(const Camera& camera, double factor) {
  CameraChange change = CameraChange::Zero();
  change[kFocalAt] = std::log(factor);
  return ChangedCamera(camera, change);
}

Camera WithoutLens(const Camera& camera) {
  return Edited(camera,
                [](CameraParameters* edited) { edited->lens = nullptr; });
}

Camera WithExtrinsics(const Camera& camera, const Eigen::Matrix3d& R,
                      const Eigen::Vector3d& t) {
  return Edited(camera, [&](CameraParameters* edited) {
    edited->R = R;
    edited->t = t;
  });
}

Diagnosis DiagnoseScene(const FaultyScene& scene) {
  RunRequest request;
  request.cameras = scene.cameras;
  static const RunOptions kOptions =
      ReadRunOptions(ProjectFile("configs/default.toml").string(), "", "");
  return DiagnoseRecording(kOptions, request, scene.detections,
                           CalibrationUnit());
}

FrozenMatches MatchesOf(const FaultyScene& scene) {
  SceneModel model;
  model.cameras = scene.cameras;
  model.skeleton = scene.detections.header.skeleton;
  model.frame_rate_hz = scene.scene.frame_rate_hz;
  RunOptions options;
  options.estimators.mode = Mode::kPaper;
  return MatchRecording(options, model, scene.detections);
}

double AngleBetween(const Camera& a, const Camera& b) {
  const double cosine =
      std::clamp(0.5 * ((a.R() * b.R().transpose()).trace() - 1.0), -1.0, 1.0);
  return std::acos(cosine) * 180.0 / M_PI;
}

}  // namespace kinegraph::testing
