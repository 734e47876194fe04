// Tests calibration from detections alone, on scenes with known truth.
#include "solvers/rig/rig.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/lens.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/session/calibrate_recording.h"

namespace kinegraph {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

Scene Walkers(double seconds, int cameras = 3, int people = 2) {
  SceneOptions options;
  options.seed = 5;
  options.people = people;
  options.duration_s = seconds;
  options.cameras.count = cameras;
  options.cameras.arc_deg = 200.0;
  options.motion.walking = 0.8;
  options.motion.standing = 0.1;
  options.motion.sitting = 0.0;
  options.motion.turning = 0.0;
  options.motion.visitors = 0.0;
  return MakeScene(options);
}

// Input with intrinsics only; focal lengths are multiplied by `factor`.
CalibrationInput WithoutPlaces(const CameraRig& cameras, double factor = 1.0) {
  CalibrationInput input;
  input.cameras = Edited(cameras, [&](CameraParameters* camera) {
    camera->R.setIdentity();
    camera->t.setZero();
    camera->K.topLeftCorner<2, 2>() *= factor;
  });
  return input;
}

// The largest error of the rotations relative to the first camera [deg].
double RotationError(const CameraRig& truth, const CameraRig& found) {
  double worst = 0.0;
  for (size_t v = 1; v < found.size(); ++v) {
    const Eigen::Matrix3d one = truth[v].R() * truth[0].R().transpose();
    const Eigen::Matrix3d other = found[v].R() * found[0].R().transpose();
    worst = std::max(
        worst,
        kDegrees * Eigen::AngleAxisd(Eigen::Matrix3d(one.transpose() * other))
                       .angle());
  }
  return worst;
}

NoiseOptions Noise() {
  NoiseOptions noise;
  noise.joints.sigma_px = 3.0;
  noise.joints.missing_rate = 0.05;
  noise.confidence = 0.8;
  noise.tell_times = false;
  return noise;
}

// Replaces a view's detections by those of a camera in another room.
void LookElsewhere(int64_t seed, double seconds, size_t view,
                   DetectionSequence* recording) {
  SceneOptions options;
  options.seed = seed;
  options.people = 2;
  options.duration_s = seconds;
  options.cameras.count = static_cast<int>(recording->header.view_names.size());
  const DetectionSequence seen = Observe(MakeScene(options), Noise(), nullptr);
  for (size_t k = 0; k < recording->frames.size(); ++k) {
    recording->frames[k].views[view] = seen.frames[k].views[view];
  }
}

// The calibration of the recording if only the intrinsics are known.
RecordingCalibration Calibrated(const Scene& scene,
                                const DetectionSequence& recording) {
  return CalibrateRecording(RunOptions(), WithoutPlaces(scene.cameras),
                            recording);
}

TEST(Rig, RecoversCamerasClocksAndScaleFromWalkers) {
  const Scene scene = Walkers(16.0);
  NoiseOptions noise = Noise();
  noise.clock_offset_s = {0.0, 0.52, -0.33};
  const DetectionSequence recording = Observe(scene, noise, nullptr);
  const RecordingCalibration found = Calibrated(scene, recording);
  ASSERT_EQ(found.rig.verdict, RigVerdict::kCalibrated);
  // 3 px are 0.2 degrees at a focal length of 800 px; thousands of joints
  // reduce this to less than a tenth, times five for weakly determined
  // directions.
  EXPECT_LT(RotationError(scene.cameras, found.cameras), 0.1);
  // 3 px at 1 m/s correspond to about 20 ms, averaged over thousands of joints.
  const double zero = found.rig.views[0].clock_s;
  EXPECT_NEAR(found.rig.views[1].clock_s - zero, 0.52, 0.005);
  EXPECT_NEAR(found.rig.views[2].clock_s - zero, -0.33, 0.005);
  // A stature of 1.70 m is assumed; the mean of the scene is 1.72 m.
  const double apart =
      (found.cameras[1].centre() - found.cameras[0].centre()).norm();
  const double truth =
      (scene.cameras[1].centre() - scene.cameras[0].centre()).norm();
  EXPECT_NEAR(apart / truth, 1.0, 3.0 * found.scale_sigma);
  // Cameras are known to much less than a pixel, so held-out residuals are as
  // large as the others.
  for (const RigView& view : found.rig.views) {
    for (const double px : {view.left_out_px.frames, view.left_out_px.joints,
                            view.left_out_px.people}) {
      EXPECT_NEAR(px / view.mean_px, 1.0, 0.2);
    }
  }
  // The world is upright and on the floor: the heights of the cameras are
  // correct within 2.5 standard deviations of the scale, which are 15 %.
  ASSERT_TRUE(found.ground.has_value());
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    EXPECT_NEAR(found.cameras[v].centre().z(), scene.cameras[v].centre().z(),
                0.15 * scene.cameras[v].centre().z());
  }
}

// Many calibration files do not contain the size of the images.
TEST(Rig, KnownLensesNeedNoImageSizes) {
  const Scene scene = Walkers(16.0);
  const DetectionSequence recording = Observe(scene, Noise(), nullptr);
  CalibrationInput input = WithoutPlaces(scene.cameras);
  input.cameras = Edited(input.cameras, [](CameraParameters* camera) {
    camera->width_px = camera->height_px = 0;
  });
  const RecordingCalibration found =
      CalibrateRecording(RunOptions(), input, recording);
  ASSERT_EQ(found.rig.verdict, RigVerdict::kCalibrated);
  // As in RecoversCamerasClocksAndScaleFromWalkers.
  EXPECT_LT(RotationError(scene.cameras, found.cameras), 0.1);
}

// Detectors have persistent offsets and errors with a correlation time, here
// 0.15 s; neither may bias a clock.
TEST(Rig, RecoversClocksDespiteCorrelatedErrors) {
  const Scene scene = Walkers(24.0);
  NoiseOptions noise = Noise();
  noise.joints.sigma_px = 5.0;
  noise.joints.static_share = 0.5;
  noise.joints.white_share = 0.1;
  noise.joints.correlation_time_s = 0.15;
  noise.clock_offset_s = {0.0, 0.11, -0.15};
  const RecordingCalibration found =
      Calibrated(scene, Observe(scene, noise, nullptr));
  ASSERT_EQ(found.rig.verdict, RigVerdict::kCalibrated);
  for (const size_t v : {1, 2}) {
    const RigView& view = found.rig.views[v];
    EXPECT_LT(view.clock_sigma_s, 0.005);
    // Three standard deviations, plus errors that the covariance of so short a
    // recording cannot reveal.
    EXPECT_NEAR(view.clock_s - found.rig.views[0].clock_s,
                noise.clock_offset_s[v], 3.0 * view.clock_sigma_s + 0.002);
  }
}

TEST(Rig, RecoversUnknownFocalLengths) {
  const Scene scene = Walkers(16.0);
  const DetectionSequence recording = Observe(scene, Noise(), nullptr);
  CalibrationInput input = WithoutPlaces(scene.cameras, 1.25);
  input.focal_sigma = 0.3;
  const RecordingCalibration found =
      CalibrateRecording(RunOptions(), input, recording);
  ASSERT_NE(found.rig.verdict, RigVerdict::kRefused);
  // Every view has a pose, so the verdict depends only on whether all views
  // probably keep the error bounds that kCalibrated promises (rig.h).
  EXPECT_EQ(found.rig.verdict == RigVerdict::kCalibrated,
            found.rig.likely_right >= 0.8);
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    // Within three standard deviations of the covariance.
    Eigen::Index at = 0;
    for (size_t u = 0; u < v; ++u) {
      at += static_cast<Eigen::Index>(found.record.cameras[u].places.size());
    }
    const auto& places = found.record.cameras[v].places;
    const auto focal = std::find(places.begin(), places.end(), kFocalAt);
    ASSERT_NE(focal, places.end());
    at += focal - places.begin();
    const double sigma = std::sqrt(found.record.covariance(at, at));
    EXPECT_NEAR(
        std::log(found.cameras[v].focal_px() / scene.cameras[v].focal_px()),
        0.0, 3.0 * sigma);
    EXPECT_LT(sigma, 0.05);
  }
}

// A view whose left and right are exchanged would fit badly or not at all; it
// is recognised, corrected and reported.
TEST(Rig, DetectsExchangedSides) {
  const Scene scene = Walkers(12.0);
  DetectionSequence recording = Observe(scene, Noise(), nullptr);
  ExchangeSides({0, 1, 0}, &recording);
  const RecordingCalibration found = Calibrated(scene, recording);
  ASSERT_EQ(found.rig.verdict, RigVerdict::kCalibrated);
  // As accurate as without exchanged sides.
  EXPECT_LT(RotationError(scene.cameras, found.cameras), 0.1);
  ASSERT_EQ(found.rig.reasons.size(), 1u);
  EXPECT_NE(found.rig.reasons[0].find("detections.exchange_sides=[\"" +
                                      recording.header.view_names[1] + "\"]"),
            std::string::npos)
      << found.rig.reasons[0];
}

TEST(Rig, KnownCameraDistanceDeterminesTheScale) {
  const Scene scene = Walkers(10.0);
  const DetectionSequence recording = Observe(scene, Noise(), nullptr);
  CalibrationInput input = WithoutPlaces(scene.cameras);
  input.length = {KnownLength::Kind::kCameras, 5.0, "cam0", "cam1"};
  const RecordingCalibration found =
      CalibrateRecording(RunOptions(), input, recording);
  ASSERT_NE(found.rig.verdict, RigVerdict::kRefused);
  EXPECT_NEAR((found.cameras[1].centre() - found.cameras[0].centre()).norm(),
              5.0, 1e-9);
  // This distance is certain, and other lengths are not.
  const Eigen::Vector3d along =
      (found.cameras[1].centre() - found.cameras[0].centre()).normalized();
  const auto second =
      static_cast<Eigen::Index>(found.record.cameras[0].places.size());
  Eigen::VectorXd gradient =
      Eigen::VectorXd::Zero(found.record.covariance.rows());
  gradient.segment<3>(kCentreAt) = -along;
  gradient.segment<3>(second + kCentreAt) = along;
  EXPECT_NEAR(gradient.dot(found.record.covariance * gradient), 0.0, 1e-12);
  EXPECT_GT(found.record.covariance.diagonal().maxCoeff(), 1e-6);
}

// The fourth camera stands in another room.
TEST(Rig, ViewOfAnotherRoomIsLeftOut) {
  const Scene scene = Walkers(16.0, 4);
  DetectionSequence recording = Observe(scene, Noise(), nullptr);
  LookElsewhere(77, 16.0, 3, &recording);
  const RecordingCalibration found = Calibrated(scene, recording);
  ASSERT_EQ(found.rig.verdict, RigVerdict::kPartly);
  EXPECT_EQ(found.rig.used, (std::vector<int>{0, 1, 2}));
  EXPECT_FALSE(found.rig.views[3].joined);
  EXPECT_FALSE(found.rig.views[3].left_out.empty());
  EXPECT_FALSE(found.rig.reasons.empty());
  ASSERT_EQ(found.cameras.size(), 3u);
  // As accurate as with the three views alone.
  EXPECT_LT(RotationError(scene.cameras, found.cameras), 0.1);
}

// A few seconds of one person determine every view, but not to 1 % if focal
// lengths are unknown.
TEST(Rig, VerdictIsPartlyIfBoundsAreUnlikely) {
  const Scene scene = Walkers(9.0, 3, 1);
  CalibrationInput input = WithoutPlaces(scene.cameras);
  input.focal_sigma = 0.3;
  const RecordingCalibration found =
      CalibrateRecording(RunOptions(), input, Observe(scene, Noise(), nullptr));
  ASSERT_EQ(found.rig.verdict, RigVerdict::kPartly);
  EXPECT_EQ(found.cameras.size(), scene.cameras.size());
  EXPECT_LT(found.rig.likely_right, 0.5);
  ASSERT_FALSE(found.rig.reasons.empty());
  EXPECT_NE(found.rig.reasons.back().find("specify focal lengths"),
            std::string::npos);
}

// The scene with lens distortion and principal points off the image centre, as
// in real cameras.
Scene WithRealLenses(Scene scene) {
  int view = 0;
  scene.cameras = Edited(scene.cameras, [&](CameraParameters* camera) {
    camera->K(0, 2) += 0.01 * camera->width_px * (view % 2 == 0 ? 1.0 : -1.0);
    camera->K(1, 2) -= 0.008 * camera->width_px;
    camera->lens = MakeLens("opencv5", {-0.12, 0.0});
    ++view;
  });
  return scene;
}

// Input if only focal lengths and image sizes are known.
CalibrationInput WithoutLenses(const CameraRig& cameras) {
  CalibrationInput input = WithoutPlaces(cameras);
  input.lenses_known = false;
  input.focal_stated = true;
  input.focal_sigma = 0.01;
  input.cameras = Edited(input.cameras, [](CameraParameters* camera) {
    camera->K(0, 2) = 0.5 * camera->width_px;
    camera->K(1, 2) = 0.5 * camera->height_px;
    camera->lens = nullptr;
  });
  return input;
}

// If cameras are wrongly assumed to be pinholes, the shifts of their images are
// compensated by rotations. If lenses are declared unknown, the reported
// uncertainty covers this.
TEST(Rig, UnknownLensesAreEstimated) {
  const Scene scene = WithRealLenses(Walkers(16.0, 4));
  const DetectionSequence recording = Observe(scene, Noise(), nullptr);
  CalibrationInput input = WithoutLenses(scene.cameras);
  const RecordingCalibration found =
      CalibrateRecording(RunOptions(), input, recording);
  ASSERT_EQ(found.cameras.size(), 4u);
  // Three standard deviations of the difference between two cameras.
  const auto stated_deg = [](const RecordingCalibration& one) {
    double most = 0.0;
    for (const RigView& view : one.rig.views) {
      most = std::max(most, view.rotation_sigma_deg);
    }
    return 3.0 * std::sqrt(2.0) * most;
  };
  const double error_deg = RotationError(scene.cameras, found.cameras);
  EXPECT_LT(error_deg, stated_deg(found));
  if (found.rig.verdict == RigVerdict::kCalibrated) {
    EXPECT_LT(error_deg, 0.3);
  } else {
    ASSERT_FALSE(found.rig.reasons.empty());
    EXPECT_NE(found.rig.reasons.back().find("lenses that are measured"),
              std::string::npos)
        << found.rig.reasons.back();
  }
  // With pinhole cameras the error exceeds the reported uncertainty.
  input.lenses_known = true;
  const RecordingCalibration pinholes =
      CalibrateRecording(RunOptions(), input, recording);
  ASSERT_EQ(pinholes.cameras.size(), 4u);
  EXPECT_GT(RotationError(scene.cameras, pinholes.cameras),
            stated_deg(pinholes));
}

TEST(Rig, WrongFocalLengthIsReported) {
  const Scene scene = Walkers(16.0, 4);
  const DetectionSequence recording = Observe(scene, Noise(), nullptr);
  CalibrationInput right = WithoutLenses(scene.cameras);
  CalibrationInput wrong = right;
  wrong.cameras[0] = Edited(wrong.cameras[0], [](CameraParameters* camera) {
    camera->K.topLeftCorner<2, 2>() *= 1.13;
  });
  const auto contradicts = [&](const CalibrationInput& input) {
    const auto found = CalibrateRecording(RunOptions(), input, recording);
    const auto& reasons = found.rig.reasons;
    const bool said =
        std::any_of(reasons.begin(), reasons.end(), [](const auto& reason) {
          return reason.find("contradicts the focal") != std::string::npos;
        });
    if (said) {
      EXPECT_NE(found.rig.verdict, RigVerdict::kCalibrated);
    }
    // In either case the error is within the reported uncertainty.
    double sigma_deg = 0.0;
    for (const RigView& view : found.rig.views) {
      sigma_deg = std::max(sigma_deg, view.rotation_sigma_deg);
    }
    EXPECT_LT(RotationError(scene.cameras, found.cameras),
              3.0 * std::sqrt(2.0) * sigma_deg);
    return said;
  };
  EXPECT_TRUE(contradicts(wrong));
  EXPECT_FALSE(contradicts(right));
}

// A camera that is bumped a third into the recording.
TEST(Rig, ViewThatMovedIsLeftOut) {
  const Scene scene = Walkers(18.0, 4);
  Scene after = scene;
  after.cameras[2] = Edited(scene.cameras[2], [](CameraParameters* camera) {
    const Eigen::Matrix3d turn = ExpRotation({0.02, 0.05, 0.0});
    camera->R = turn * camera->R;
    camera->t = turn * camera->t;
  });
  DetectionSequence recording = Observe(scene, Noise(), nullptr);
  const DetectionSequence later = Observe(after, Noise(), nullptr);
  const size_t step = recording.frames.size() / 3;
  for (size_t k = step; k < recording.frames.size(); ++k) {
    recording.frames[k].views[2] = later.frames[k].views[2];
  }
  const RecordingCalibration found = Calibrated(scene, recording);
  ASSERT_EQ(found.rig.verdict, RigVerdict::kPartly);
  EXPECT_EQ(found.rig.used, (std::vector<int>{0, 1, 3}));
  const std::string& why = found.rig.views[2].left_out;
  const size_t at = why.find("at about frame ");
  ASSERT_NE(at, std::string::npos) << why;
  // Within a second.
  EXPECT_NEAR(std::stod(why.substr(at + 15)), static_cast<double>(step),
              recording.header.frame_rate_hz);
}

// Cameras that share a trigger have no clock errors.
TEST(Rig, SynchronisedViewsHaveNoClocks) {
  const Scene scene = Walkers(12.0);
  CalibrationInput input = WithoutPlaces(scene.cameras);
  input.in_step = true;
  const RecordingCalibration found =
      CalibrateRecording(RunOptions(), input, Observe(scene, Noise(), nullptr));
  ASSERT_EQ(found.rig.verdict, RigVerdict::kCalibrated);
  for (const RigView& view : found.rig.views) {
    EXPECT_EQ(view.clock_s, 0.0);
    EXPECT_EQ(view.clock_sigma_s, 0.0);
  }
}

// Walks in a circle at a constant speed, with 0.9 strides per second.
class WalksRound : public Actor {
 public:
  WalksRound(double radius_m, double speed_mps, const Eigen::Vector2d& centre,
             double heading_rad, double phase_rad)
      : radius_m_(radius_m),
        speed_mps_(speed_mps),
        centre_(centre),
        heading_rad_(heading_rad),
        phase_rad_(phase_rad) {}

  bool PresentAt(double) const override { return true; }

  Pose3d PoseAt(double time_s) const override {
    const SegmentPose trunk = TrunkAt(time_s);
    const double stride = 2.0 * M_PI * 0.9 * time_s + phase_rad_;
    Pose3d pose(17);
    // x forward, y to the left, z up.
    const auto put = [&](const std::string& name, double x, double y,
                         double z) {
      const Eigen::Vector3d at = trunk.origin_m + trunk.R * Vector3d(x, y, z);
      pose[Coco17().IndexOf(name)] = {at, JointStatus::kObserved};
    };
    put("nose", 0.12, 0.0, 0.67);
    for (const double side : {1.0, -1.0}) {
      const std::string of = side > 0.0 ? "l_" : "r_";
      const double leg = 0.45 * side * std::sin(stride);
      const double arm = -0.8 * leg;
      const double shin =
          leg - 0.25 - 0.3 * std::max(0.0, side * std::sin(stride + 2.0));
      put(of + "eye", 0.09, 0.032 * side, 0.71);
      put(of + "ear", 0.02, 0.075 * side, 0.68);
      put(of + "shoulder", 0.02, 0.18 * side, 0.5);
      const double elbow_x = 0.02 + 0.29 * std::sin(arm);
      const double elbow_z = 0.5 - 0.29 * std::cos(arm);
      put(of + "elbow", elbow_x, 0.21 * side, elbow_z);
      put(of + "wrist", elbow_x + 0.25 * std::sin(arm + 0.4), 0.2 * side,
          elbow_z - 0.25 * std::cos(arm + 0.4));
      put(of + "hip", 0.0, 0.11 * side, -0.02);
      const double knee_x = 0.43 * std::sin(leg);
      const double knee_z = -0.02 - 0.43 * std::cos(leg);
      put(of + "knee", knee_x, 0.115 * side, knee_z);
      put(of + "ankle", knee_x + 0.42 * std::sin(shin), 0.115 * side,
          knee_z - 0.42 * std::cos(shin));
    }
    return pose;
  }

  SegmentPose TrunkAt(double time_s) const override {
    const double angle = heading_rad_ + speed_mps_ / radius_m_ * time_s;
    const double stride = 2.0 * M_PI * 0.9 * time_s + phase_rad_;
    SegmentPose trunk;
    trunk.R = Eigen::AngleAxisd(angle, Vector3d::UnitZ());
    trunk.origin_m = {centre_.x() + radius_m_ * std::sin(angle),
                      centre_.y() - radius_m_ * std::cos(angle),
                      0.92 + 0.02 * std::cos(2.0 * stride)};
    return trunk;
  }

  Obstacle ObstacleAt(double time_s) const override {
    return Obstacle({}, TrunkAt(time_s).origin_m);
  }

  ActorFacts Facts() const override { return ActorFacts(); }

 private:
  using Vector3d = Eigen::Vector3d;

  double radius_m_;
  double speed_mps_;
  Eigen::Vector2d centre_;
  double heading_rad_;
  double phase_rad_;
};

// Four cameras around people who walk in circles.
Scene Rounds(std::vector<std::shared_ptr<const Actor>> people, double seconds) {
  SceneOptions options;
  options.duration_s = seconds;
  options.frame_rate_hz = 30.0;
  options.cameras.count = 4;
  options.cameras.radius_m = 5.0;
  options.cameras.height_m = 2.2;
  options.cameras.focal_px = 900.0;
  return MakeScene(options, Coco17(), std::move(people));
}

// After some strides, a person who walks in a circle is in the same phase of
// the gait but turned, as if seen from another direction; the correct lag is
// found nevertheless.
TEST(Rig, RecoversALateViewOfPeopleWalkingInCircles) {
  const Eigen::Vector2d aside(0.3, 0.5);
  const Scene scene =
      Rounds({std::make_shared<WalksRound>(1.6, 1.2, Eigen::Vector2d(0.0, 0.0),
                                           0.0, 0.0),
              std::make_shared<WalksRound>(1.0, 1.0, aside, 2.0, 1.0)},
             30.0);
  NoiseOptions noise = Noise();
  noise.clock_offset_s = {0.0, 1.0, 0.0, 0.0};
  const RecordingCalibration found =
      Calibrated(scene, Observe(scene, noise, nullptr));
  ASSERT_EQ(found.rig.verdict, RigVerdict::kCalibrated);
  EXPECT_LT(RotationError(scene.cameras, found.cameras), 0.1);
  for (size_t v = 0; v < found.rig.views.size(); ++v) {
    EXPECT_NEAR(found.rig.views[v].clock_s, noise.clock_offset_s[v], 0.005);
  }
}

// After each stride, a person who walks in a circle looks the same from a
// turned direction. With a single person the lag is therefore ambiguous.
TEST(Rig, OneRegularWalkerDoesNotDetermineClocks) {
  const Scene scene =
      Rounds({std::make_shared<WalksRound>(1.0, 1.0, Eigen::Vector2d(0.3, 0.5),
                                           2.0, 1.0)},
             20.0);
  const RecordingCalibration found =
      Calibrated(scene, Observe(scene, Noise(), nullptr));
  EXPECT_NE(found.rig.verdict, RigVerdict::kCalibrated);
  EXPECT_LE(found.rig.likely_right, 0.5);
}

// The second person does the same as the first, rotated by half a turn, so that
// each camera may as well stand at the opposite side.
TEST(Rig, PeopleWhoCanBeExchangedAreReported) {
  Scene scene = Walkers(16.0, 3, 1);
  NoiseOptions noise = Noise();
  DetectionSequence recording = Observe(scene, noise, nullptr);
  Scene turned = scene;
  turned.cameras = Edited(scene.cameras, [](CameraParameters* camera) {
    camera->R *= Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).matrix();
  });
  noise.seed = 2;
  const DetectionSequence second = Observe(turned, noise, nullptr);
  for (size_t k = 0; k < recording.frames.size(); ++k) {
    for (size_t v = 0; v < scene.cameras.size(); ++v) {
      auto& detections = recording.frames[k].views[v].detections;
      for (Detection other : second.frames[k].views[v].detections) {
        other.index_in_file = static_cast<int>(detections.size());
        detections.push_back(std::move(other));
      }
    }
  }
  const RecordingCalibration found = Calibrated(scene, recording);
  EXPECT_EQ(found.rig.verdict, RigVerdict::kRefused);
  ASSERT_FALSE(found.rig.reasons.empty());
  // The cause is given once, for all views.
  const std::string& why = found.rig.reasons[0];
  const size_t at = why.find("move so much alike");
  EXPECT_NE(at, std::string::npos) << why;
  EXPECT_EQ(at, why.rfind("move so much alike")) << why;
}

// A detector runs on every second frame. The result with the original frame
// numbers differs only by rounding from that with consecutive numbers at half
// the frame rate.
TEST(Rig, EverySecondFrameEqualsARecordingAtHalfTheFrameRate) {
  const Scene scene = Walkers(20.0);
  NoiseOptions noise = Noise();
  noise.clock_offset_s = {0.0, 0.24, 0.0};
  const DetectionSequence all = Observe(scene, noise, nullptr);
  DetectionSequence numbered = all;
  numbered.frames.clear();
  for (size_t k = 0; k < all.frames.size(); k += 2) {
    numbered.frames.push_back(all.frames[k]);
  }
  DetectionSequence renumbered = numbered;
  renumbered.header.frame_rate_hz *= 0.5;
  for (DetectionFrame& frame : renumbered.frames) frame.frame /= 2;
  const RigResult rig = Calibrated(scene, numbered).rig;
  const RigResult expected = Calibrated(scene, renumbered).rig;
  ASSERT_TRUE(expected.clocks_told);
  EXPECT_TRUE(rig.clocks_told);
  EXPECT_EQ(rig.verdict, expected.verdict);
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    EXPECT_NEAR(rig.views[v].clock_s, expected.views[v].clock_s, 1e-6);
    EXPECT_NEAR(rig.views[v].clock_sigma_s, expected.views[v].clock_sigma_s,
                1e-6);
    EXPECT_NEAR(rig.views[v].rotation_sigma_deg,
                expected.views[v].rotation_sigma_deg, 1e-6);
  }
}

TEST(Rig, RefusesAGapOfTooManyFrames) {
  const Scene scene = Walkers(4.0);
  DetectionSequence recording = Observe(scene, Noise(), nullptr);
  for (size_t k = 50; k < recording.frames.size(); ++k) {
    recording.frames[k].frame += 3'000'000;
  }
  try {
    Calibrated(scene, recording);
    FAIL() << "expected an error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("--detections: frame 49 is followed by frame 3000050"),
              std::string::npos)
        << error.what();
  }
}

TEST(Rig, RefusesSinglePoints) {
  const Scene scene = Walkers(5.0);
  DetectionSequence points = Observe(scene, Noise(), nullptr);
  points.header.skeleton = Skeleton("ball", {"ball"}, {});
  for (DetectionFrame& frame : points.frames) {
    for (ViewDetections& view : frame.views) {
      for (Detection& one : view.detections) one.joints.resize(1);
    }
  }
  const RecordingCalibration found = Calibrated(scene, points);
  EXPECT_EQ(found.rig.verdict, RigVerdict::kRefused);
  ASSERT_FALSE(found.rig.reasons.empty());
  EXPECT_NE(found.rig.reasons[0].find("two joints"), std::string::npos)
      << found.rig.reasons[0];
}

TEST(Rig, RefusesViewsOfDifferentRoomsAndEmptyViews) {
  const Scene scene = Walkers(10.0);
  DetectionSequence apart = Observe(scene, Noise(), nullptr);
  DetectionSequence nobody = apart;
  LookElsewhere(77, 10.0, 1, &apart);
  LookElsewhere(78, 10.0, 2, &apart);
  for (DetectionFrame& frame : nobody.frames) {
    for (ViewDetections& view : frame.views) view.detections.clear();
  }
  for (const DetectionSequence& recording : {apart, nobody}) {
    const RecordingCalibration found = Calibrated(scene, recording);
    EXPECT_EQ(found.rig.verdict, RigVerdict::kRefused);
    EXPECT_FALSE(found.rig.reasons.empty());
    EXPECT_TRUE(found.cameras.empty());
  }
}

}  // namespace
}  // namespace kinegraph
