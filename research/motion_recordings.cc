#include "research/motion_recordings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/constants.h"
#include "core/base/random.h"
#include "core/io/tracks/tracks.h"
#include "core/synthetic/recorded_people.h"
#include "solvers/filters/causal_gaussian.h"
#include "solvers/filters/smoothing_spline.h"

namespace kinegraph::testing {
namespace {

// AR(1) errors of unit variance per axis.
class SlowNoise {
 public:
  Eigen::Vector2d Next(double correlation, Random* random) {
    const double y = random->Normal();
    const double x = random->Normal();
    const Eigen::Vector2d fresh(x, y);
    state_ = started_ ? Eigen::Vector2d(
                            correlation * state_ +
                            std::sqrt(1.0 - correlation * correlation) * fresh)
                      : fresh;
    started_ = true;
    return state_;
  }

 private:
  Eigen::Vector2d state_ = Eigen::Vector2d::Zero();
  bool started_ = false;
};

DetectionSequence Detect(const SteadyClip& clip, const CameraRig& cameras,
                         const DetectorModel& detector, uint64_t seed) {
  Random random(seed);
  const double correlation =
      detector.correlation_time_s > 0.0
          ? std::exp(-1.0 / (clip.rate_hz * detector.correlation_time_s))
          : 0.0;
  const FrameClock clock(clip.rate_hz);
  const size_t joint_count = clip.joints_m.front().size();
  std::vector<SlowNoise> slow(cameras.size() * joint_count);
  DetectionSequence sequence;
  sequence.header.skeleton = clip.skeleton;
  sequence.header.frame_rate_hz = clip.rate_hz;
  for (const Camera& camera : cameras) {
    sequence.header.view_names.push_back(camera.name());
  }
  for (size_t k = 0; k < clip.joints_m.size(); ++k) {
    DetectionFrame& frame = sequence.frames.emplace_back();
    frame.frame = static_cast<int64_t>(k);
    frame.time = clock.TimeOf(frame.frame);
    for (size_t c = 0; c < cameras.size(); ++c) {
      ViewDetections& view = frame.views.emplace_back();
      view.capture_time = frame.time;
      Detection& detection = view.detections.emplace_back();
      detection.joints.resize(joint_count);
      for (size_t j = 0; j < joint_count; ++j) {
        // All numbers are drawn in every frame, so that turning off one kind of
        // noise leaves the others unchanged.
        const Eigen::Vector2d error =
            detector.sigma_px *
            slow[c * joint_count + j].Next(correlation, &random);
        const bool outlier = random.Chance(detector.outliers);
        const double angle = random.Uniform(0.0, 2.0 * kPi);
        const bool missing = random.Chance(detector.missing);
        const auto px = cameras[c].Project(clip.joints_m[k][j]);
        if (missing || !px.has_value()) continue;
        Keypoint& joint = detection.joints[j];
        joint.found = true;
        joint.confidence = 1.0;
        joint.px = *px + error;
        if (outlier) {
          joint.px += detector.outlier_px *
                      Eigen::Vector2d(std::cos(angle), std::sin(angle));
        }
      }
    }
  }
  return sequence;
}

}  // namespace

SteadyClip LoadSteadyClip(const std::string& path) {
  const TrackSequence tracks = ReadTracks(path);
  SteadyClip clip;
  clip.skeleton = tracks.header.skeleton;
  clip.rate_hz = tracks.header.frame_rate_hz;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9);
  Eigen::Vector3d high = -low;
  for (const TrackFrame& frame : tracks.frames) {
    auto& joints = clip.joints_m.emplace_back();
    for (const Joint3d& joint : frame.people.at(0).joints) {
      if (!joint.present()) throw std::runtime_error(path + ": missing joint");
      joints.push_back(joint.position_m);
      low = low.cwiseMin(joint.position_m);
      high = high.cwiseMax(joint.position_m);
    }
  }
  if (clip.joints_m.size() < 3) {  // too few for the spline of Resample
    throw std::runtime_error(path + ": fewer than three frames");
  }
  Eigen::Vector3d middle = 0.5 * (low + high);
  middle.z() = 0.0;
  for (auto& joints : clip.joints_m) {
    for (Eigen::Vector3d& joint : joints) joint -= middle;
  }
  return clip;
}

SteadyClip Resample(const SteadyClip& clip, double rate_hz) {
  if (rate_hz == clip.rate_hz) return clip;
  const size_t joint_count = clip.joints_m.front().size();
  const size_t count = clip.joints_m.size();
  std::vector<double> times_s(count);
  Samples values(static_cast<Eigen::Index>(count),
                 static_cast<Eigen::Index>(3 * joint_count));
  for (size_t k = 0; k < count; ++k) {
    times_s[k] = static_cast<double>(k) / clip.rate_hz;
    for (size_t j = 0; j < joint_count; ++j) {
      values.block<1, 3>(k, 3 * j) = clip.joints_m[k][j].transpose();
    }
  }
  std::vector<double> at_s;
  for (size_t k = 0; static_cast<double>(k) / rate_hz <= times_s.back(); ++k) {
    at_s.push_back(static_cast<double>(k) / rate_hz);
  }
  const Samples there = SmoothingSpline(0.0, times_s, values, at_s);
  SteadyClip resampled;
  resampled.skeleton = clip.skeleton;
  resampled.rate_hz = rate_hz;
  for (size_t k = 0; k < at_s.size(); ++k) {
    auto& joints = resampled.joints_m.emplace_back();
    for (size_t j = 0; j < joint_count; ++j) {
      joints.push_back(there.block<1, 3>(k, 3 * j).transpose());
    }
  }
  return resampled;
}

SteadyClip FirstSeconds(const SteadyClip& clip, double seconds) {
  SteadyClip first = clip;
  const auto count = static_cast<size_t>(std::lround(seconds * clip.rate_hz));
  if (count < first.joints_m.size()) first.joints_m.resize(count);
  return first;
}

SteadyClip WithJointSway(const SteadyClip& clip, double amplitude_m,
                         uint64_t seed) {
  MotionClip recorded;
  recorded.tracks.header.skeleton = clip.skeleton;
  Eigen::Vector2d low = clip.joints_m.front().front().head<2>(), high = low;
  for (size_t k = 0; k < clip.joints_m.size(); ++k) {
    PersonPose person;
    person.id = TrackId(0);
    for (const Eigen::Vector3d& joint : clip.joints_m[k]) {
      person.joints.push_back({joint, JointStatus::kObserved});
      low = low.cwiseMin(joint.head<2>());
      high = high.cwiseMax(joint.head<2>());
    }
    recorded.tracks.frames.push_back(
        {static_cast<int64_t>(k),
         FromSeconds(static_cast<double>(k) / clip.rate_hz),
         {std::move(person)}});
  }
  // Keeps the position of the clip.
  RecordedPeopleOptions options;
  options.x_m = {0.5 * (low.x() + high.x())};
  options.y_m = {0.5 * (low.y() + high.y())};
  options.turn_deg = {0.0};
  options.joint_sway_m = amplitude_m;
  ClipRoom room;
  room.seed = seed;
  const auto people =
      MakeRecordedPeople(options, {recorded}, clip.skeleton, room);
  SteadyClip swaying = clip;
  for (size_t k = 0; k < clip.joints_m.size(); ++k) {
    const Pose3d pose =
        people.front()->PoseAt(ToSeconds(recorded.tracks.frames[k].time));
    for (size_t j = 0; j < pose.size(); ++j) {
      swaying.joints_m[k][j] = pose[j].position_m;
    }
  }
  return swaying;
}

SteadyClip AfterRest(const SteadyClip& clip, double seconds) {
  SteadyClip longer = clip;
  longer.joints_m.clear();
  const auto count = static_cast<size_t>(std::lround(seconds * clip.rate_hz));
  for (size_t k = 0; k < count; ++k) {
    const double t = static_cast<double>(k) / clip.rate_hz;
    const double fade = std::min(1.0, (seconds - t) / 2.0);
    const Eigen::Vector3d sway(fade * (0.004 * std::sin(2.0 * kPi * 0.31 * t) +
                                       0.002 * std::sin(2.0 * kPi * 0.83 * t)),
                               fade * (0.003 * std::sin(2.0 * kPi * 0.43 * t) +
                                       0.002 * std::sin(2.0 * kPi * 0.71 * t)),
                               0.0);
    auto& joints = longer.joints_m.emplace_back();
    for (const Eigen::Vector3d& joint : clip.joints_m.front()) {
      // The feet stay in place.
      joints.push_back(joint + std::min(1.0, joint.z()) * sway);
    }
  }
  longer.joints_m.insert(longer.joints_m.end(), clip.joints_m.begin(),
                         clip.joints_m.end());
  return longer;
}

CameraRig MotionCameras(int count) {
  CameraRig cameras;
  for (int c = 0; c < count; ++c) {
    const double angle = 2.0 * kPi * c / count + 0.4;
    const Eigen::Vector3d centre(5.0 * std::cos(angle), 5.0 * std::sin(angle),
                                 1.2);
    const Eigen::Vector3d forward(-std::cos(angle), -std::sin(angle), 0.0);
    const Eigen::Vector3d down(0.0, 0.0, -1.0);
    CameraParameters parameters;
    parameters.name = "cam" + std::to_string(c);
    parameters.width_px = 1920;
    parameters.height_px = 1080;
    parameters.K << 1250.0, 0.0, 960.0, 0.0, 1250.0, 540.0, 0.0, 0.0, 1.0;
    parameters.R.row(0) = down.cross(forward);
    parameters.R.row(1) = down;
    parameters.R.row(2) = forward;
    parameters.t = -parameters.R * centre;
    cameras.emplace_back(parameters);
  }
  return cameras;
}

MotionRecording ObserveMotion(const SteadyClip& clip, const CameraRig& cameras,
                              const DetectorModel& detector, uint64_t seed) {
  MotionRecording recording;
  recording.clip = clip;
  recording.scene.cameras = cameras;
  recording.scene.skeleton = clip.skeleton;
  recording.scene.frame_rate_hz = clip.rate_hz;
  const DetectionSequence detections = Detect(clip, cameras, detector, seed);
  FrozenMatches matches;
  FrozenPerson& person = matches.people.emplace_back();
  person.id = TrackId(0);
  for (const DetectionFrame& frame : detections.frames) {
    FrozenFrame& frozen = person.frames.emplace_back();
    frozen.frame = frame.frame;
    frozen.time = frame.time;
    frozen.written = true;
    for (size_t c = 0; c < cameras.size(); ++c) {
      frozen.detections.push_back({static_cast<int>(c), 0});
    }
  }
  recording.replay = std::make_shared<Replay>(
      recording.scene, detections, matches, TrackerOptions(),
      [](const SceneModel& scene) {
        return MakeCausalGaussian(scene, CausalGaussianOptions());
      });
  std::vector<ReplayedPerson> people = recording.replay->Prepare(-1, 1);
  if (people.empty()) throw std::runtime_error("no pose could be triangulated");
  recording.person = std::move(people.front());
  recording.first_frame = recording.person.frames.front().frame;
  return recording;
}

}  // namespace kinegraph::testing
