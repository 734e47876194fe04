#include "tests/support/simulated_person.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "core/base/constants.h"
#include "solvers/batch/batch_estimator.h"
#include "solvers/graph/assembler.h"
#include "solvers/window/window_estimator.h"

namespace kinegraph::testing {
namespace {

Eigen::Vector3d NormalVector(Random* random) {
  const double x = random->Normal();
  const double y = random->Normal();
  return {x, y, random->Normal()};
}

// The error of one joint in one view over time: first-order correlated, with
// outliers that keep their offset for a burst.
class PixelNoise {
 public:
  PixelNoise(const SimulatedNoise& noise, double frame_rate_hz)
      : noise_(noise),
        rho_(noise.correlation_time_s > 0.0
                 ? std::exp(-1.0 / frame_rate_hz / noise.correlation_time_s)
                 : 0.0) {}

  Eigen::Vector2d Next(double sigma_px, Random* random) {
    const double fresh = started_ ? std::sqrt(1.0 - rho_ * rho_) : 1.0;
    const double x = random->Normal();
    const Eigen::Vector2d normal(x, random->Normal());
    error_ = (started_ ? rho_ : 0.0) * error_ + fresh * normal;
    started_ = true;
    if (burst_left_ == 0 &&
        random->Chance(noise_.outliers / noise_.outlier_burst)) {
      burst_left_ = noise_.outlier_burst;
      const double size =
          random->Uniform(noise_.outlier_low_px, noise_.outlier_high_px);
      const double angle = random->Uniform(0.0, 2.0 * kPi);
      outlier_ = size * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    const Eigen::Vector2d good = noise_.sigma_scale * sigma_px * error_;
    if (burst_left_ == 0) return good;
    --burst_left_;
    return good + outlier_;
  }

 private:
  SimulatedNoise noise_;
  double rho_;
  bool started_ = false;
  Eigen::Vector2d error_ = Eigen::Vector2d::Zero();
  int burst_left_ = 0;
  Eigen::Vector2d outlier_ = Eigen::Vector2d::Zero();
};

Eigen::Vector3d MeanPosition(const std::vector<std::vector<State>>& truth,
                             size_t frame) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::vector<State>& joint : truth) sum += joint[frame].head<3>();
  return sum / static_cast<double>(truth.size());
}

// Point nearest to all rays in the least-squares sense.
Joint3d NearestToRays(const CameraRig& cameras,
                      const std::vector<std::vector<Keypoint>>& views,
                      size_t joint) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  int count = 0;
  for (size_t c = 0; c < cameras.size(); ++c) {
    if (!views[c][joint].found) continue;
    const auto ideal = cameras[c].Undistort(views[c][joint].px);
    if (!ideal.has_value()) continue;
    const Eigen::Vector3d ray = cameras[c].RayDirection(*ideal);
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - ray * ray.transpose();
    normal += across;
    right += across * cameras[c].centre();
    ++count;
  }
  Joint3d result;
  if (count < 2) return result;
  result.position_m = normal.ldlt().solve(right);
  if (result.position_m.allFinite()) result.status = JointStatus::kObserved;
  return result;
}

EstimatorFrame FrameAt(const SceneModel& scene, size_t k) {
  EstimatorFrame frame;
  frame.frame = static_cast<int64_t>(k);
  frame.time = FrameClock(scene.frame_rate_hz).TimeOf(frame.frame);
  return frame;
}

}  // namespace

CameraRig RingOfCameras(int count, double radius_m, double focal_px,
                        bool with_lens) {
  CameraRig cameras;
  for (int c = 0; c < count; ++c) {
    const double angle = 2.0 * kPi * c / count + 0.3;
    const Eigen::Vector3d centre(radius_m * std::cos(angle),
                                 radius_m * std::sin(angle), 1.0);
    const Eigen::Vector3d forward(-std::cos(angle), -std::sin(angle), 0.0);
    const Eigen::Vector3d down(0.0, 0.0, -1.0);
    CameraParameters parameters;
    parameters.name = "cam" + std::to_string(c);
    parameters.width_px = parameters.height_px = 2000;
    parameters.K << focal_px, 0.0, 1000.0, 0.0, focal_px, 1000.0, 0.0, 0.0, 1.0;
    parameters.R.row(0) = down.cross(forward);
    parameters.R.row(1) = down;
    parameters.R.row(2) = forward;
    parameters.t = -parameters.R * centre;
    if (with_lens) {
      parameters.lens = MakeLens("opencv5", {-0.1, 0.02, 0.001, -0.0005, 0.0});
    }
    cameras.emplace_back(parameters);
  }
  return cameras;
}

GraphOptions FixedNoise() {
  GraphOptions options;
  options.pixel_noise_from = NoiseFrom::kFixed;
  options.process_noise_from = NoiseFrom::kFixed;
  options.bone_sigma_from = NoiseFrom::kFixed;
  return options;
}

Skeleton SmallSkeleton() {
  return Skeleton("arm", {"r_shoulder", "r_elbow", "r_wrist"},
                  {{0, 1}, {1, 2}});
}

SceneModel SmallScene(CameraRig cameras, double frame_rate_hz) {
  SceneModel scene;
  scene.cameras = std::move(cameras);
  scene.skeleton = SmallSkeleton();
  scene.frame_rate_hz = frame_rate_hz;
  return scene;
}

void SimulatedRecording::Connect() {
  for (size_t k = 0; k < frames.size(); ++k) {
    for (FreshView& view : frames[k].views) {
      view.joints = keypoints[k][view.view_idx];
    }
  }
}

std::vector<std::vector<State>> MotionFromPrior(const SceneModel& scene,
                                                const GraphOptions& options,
                                                const Eigen::Vector3d& centre,
                                                int frame_count,
                                                Random* random) {
  std::vector<std::vector<State>> truth(scene.skeleton.joint_count());
  for (size_t j = 0; j < truth.size(); ++j) {
    const int joint_class =
        static_cast<int>(scene.skeleton.joint_class(static_cast<int>(j)));
    State state;
    state.head<3>() =
        centre + options.birth_position_sigma_m * NormalVector(random);
    state.tail<3>() = options.birth_velocity_sigma_mps * NormalVector(random);
    truth[j].push_back(state);
    for (int k = 1; k < frame_count; ++k) {
      const double dt_s =
          ToSeconds(FrameAt(scene, k).time - FrameAt(scene, k - 1).time);
      // Q = L L' of factors.h, L = sqrt(q dt) [dt / sqrt 3, 0;
      // sqrt 3 / 2, 1 / 2].
      const double root = std::sqrt(options.process_noise[joint_class] * dt_s);
      const Eigen::Vector3d a = NormalVector(random);
      const Eigen::Vector3d b = NormalVector(random);
      state.head<3>() +=
          dt_s * state.tail<3>() + root * dt_s / std::sqrt(3.0) * a;
      state.tail<3>() += root * (0.5 * std::sqrt(3.0) * a + 0.5 * b);
      truth[j].push_back(state);
    }
  }
  return truth;
}

std::vector<std::vector<State>> WalkingMotion(const SceneModel& scene,
                                              int frame_count) {
  std::vector<std::vector<State>> truth(scene.skeleton.joint_count());
  for (size_t j = 0; j < truth.size(); ++j) {
    const double index = static_cast<double>(j);
    const Eigen::Vector3d in_body(0.3 * std::cos(index),
                                  0.2 * std::sin(2.0 * index), 0.1 * index);
    for (int k = 0; k < frame_count; ++k) {
      const double t = ToSeconds(FrameAt(scene, k).time);
      const Eigen::Vector3d turned =
          Eigen::AngleAxisd(t, Eigen::Vector3d::UnitZ()) * in_body;
      const double bounce = 2.0 * kPi * 2.0;  // 2 Hz
      State state;
      state.head<3>() = turned + Eigen::Vector3d(std::cos(t), std::sin(t),
                                                 0.03 * std::sin(bounce * t));
      state.tail<3>() = Eigen::Vector3d::UnitZ().cross(turned) +
                        Eigen::Vector3d(-std::sin(t), std::cos(t),
                                        0.03 * bounce * std::cos(bounce * t));
      truth[j].push_back(state);
    }
  }
  return truth;
}

SimulatedRecording Simulate(const SceneModel& scene,
                            const GraphOptions& options,
                            std::vector<std::vector<State>> truth,
                            const SimulatedNoise& noise,
                            const Eigen::Vector3d& centre, Random* random) {
  const size_t joint_count = truth.size();
  const size_t frame_count = truth.front().size();
  const size_t camera_count = scene.cameras.size();
  std::vector<PixelNoise> errors(joint_count * camera_count,
                                 PixelNoise(noise, scene.frame_rate_hz));
  SimulatedRecording recording;
  recording.truth = std::move(truth);
  for (size_t k = 0; k < frame_count; ++k) {
    EstimatorFrame frame = FrameAt(scene, k);
    const Eigen::Vector3d middle =
        noise.initial_poses ? MeanPosition(recording.truth, k) : centre;
    std::vector<std::vector<Keypoint>> views(camera_count);
    for (size_t c = 0; c < camera_count; ++c) {
      const Camera& camera = scene.cameras[c];
      views[c].resize(joint_count);
      for (size_t j = 0; j < joint_count; ++j) {
        const double confidence =
            random->Uniform(noise.confidence_low, noise.confidence_high);
        const double sigma_px =
            PixelSigma(options, scene.skeleton.joint_class(static_cast<int>(j)),
                       confidence, camera.Depth(middle), camera.focal_px());
        const Eigen::Vector2d error =
            errors[c * joint_count + j].Next(sigma_px, random);
        const auto px = camera.Project(recording.truth[j][k].head<3>());
        if (random->Chance(noise.missing) || !px.has_value()) continue;
        views[c][j].px = *px + error;
        views[c][j].confidence = confidence;
        views[c][j].found = true;
      }
      FreshView view;
      view.view_idx = static_cast<int>(c);
      view.capture_time = frame.time;
      frame.views.push_back(view);
    }
    frame.has_initial = k == 0 || noise.initial_poses;
    if (frame.has_initial) frame.initial.resize(joint_count);
    for (size_t j = 0; j < frame.initial.size(); ++j) {
      if (noise.initial_poses) {
        frame.initial[j] = NearestToRays(scene.cameras, views, j);
      } else {
        frame.initial[j].position_m = centre;
        frame.initial[j].status = JointStatus::kInferred;
      }
    }
    recording.keypoints.push_back(std::move(views));
    recording.frames.push_back(std::move(frame));
  }
  recording.Connect();
  return recording;
}

SimulatedRecording Simulate(const SceneModel& scene,
                            const GraphOptions& options,
                            std::vector<std::vector<State>> truth,
                            const SimulatedNoise& noise, uint64_t seed) {
  Random random(seed);
  return Simulate(scene, options, std::move(truth), noise,
                  Eigen::Vector3d::Zero(), &random);
}

PersonProblem Assemble(const SceneModel& scene, const GraphOptions& options,
                       const std::vector<EstimatorFrame>& frames) {
  Assembler assembler(scene, options);
  PersonProblem problem;
  for (const EstimatorFrame& frame : frames) assembler.Append(frame, &problem);
  return problem;
}

std::unique_ptr<Estimator> MakeEstimator(bool batch, const SceneModel& scene,
                                         const GraphOptions& options) {
  return batch ? MakeBatchEstimator(scene, options)
               : MakeWindowEstimator(scene, options);
}

std::vector<FinalPose> Run(Estimator* estimator,
                           const std::vector<EstimatorFrame>& frames) {
  std::vector<FinalPose> finals;
  for (const EstimatorFrame& frame : frames) {
    estimator->Add(frame);
    estimator->ExtractFinals(&finals);
  }
  estimator->Finish();
  estimator->ExtractFinals(&finals);
  return finals;
}

double RootMeanSquare(const std::vector<std::vector<State>>& truth,
                      const std::vector<FinalPose>& finals, size_t first) {
  double sum = 0.0;
  double count = 0.0;
  for (size_t k = first; k < finals.size(); ++k) {
    const Pose3d& joints = finals[k].person.joints;
    for (size_t j = 0; j < joints.size(); ++j) {
      if (!joints[j].present()) continue;
      sum += (joints[j].position_m - truth[j][k].head<3>()).squaredNorm();
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : INFINITY;
}

}  // namespace kinegraph::testing
