#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/constants.h"
#include "core/base/random.h"
#include "solvers/noise/bias_learner.h"
#include "solvers/noise/bias_model.h"
#include "solvers/noise/recording_notes.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

// A left hip and optionally a knee, observed by five cameras ten times per
// second for a minute.
struct BodyRecording {
  double turns = 6.0;  // of the body, in total
  double noise_px = 2.0;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  // in the body's axes
  ViewBias::OfJoint bias;                              // of the hip
  bool with_knee = false;
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  // of camera 1's images
  bool removes_shifts = false;
  size_t seeing_cameras = 5;  // the others see nobody
};

class ViewBiasTest : public ::testing::Test {
 protected:
  ViewBiasTest()
      : cameras_(testing::RingOfCameras(5, 5.0, 1250.0)),
        skeleton_(Coco17()),
        joints_(skeleton_),
        hip_(skeleton_.IndexOf("l_hip")),
        entry_(static_cast<size_t>(joints_.IndexOf(hip_))),
        classes_(joints_.classes()) {}

  static BodyStance StanceAt(double heading) {
    BodyAxes axes;
    axes.forward = {std::cos(heading), std::sin(heading), 0.0};
    axes.left = {-std::sin(heading), std::cos(heading), 0.0};
    return {axes, axes};
  }

  std::vector<BiasView> Views(const BodyRecording& recording,
                              const BodyStance& stance, int joint,
                              Random* random) const {
    const Eigen::Vector3d point =
        Eigen::Vector3d(0.3, 0.2, joint == hip_ ? 0.9 : 0.5) +
        0.15 * stance.trunk.left;
    const Eigen::Vector3d detected =
        point + recording.offset_m.x() * stance.trunk.forward +
        recording.offset_m.y() * stance.trunk.left +
        recording.offset_m.z() * stance.trunk.up;
    std::vector<BiasView> views(recording.seeing_cameras);
    for (size_t v = 0; v < views.size(); ++v) {
      BiasView& view = views[v];
      view.view_idx = static_cast<int>(v);
      view.direction = *DirectionOf(joints_, stance, joint, point, cameras_[v]);
      const Eigen::Vector2d px = *cameras_[v].Project(point, &view.jacobian);
      view.residual_px = *cameras_[v].Project(detected) - px;
      if (joint == hip_) {
        view.residual_px += BiasOf(recording.bias, view.direction);
      }
      if (v == 1) view.residual_px += recording.shift_px;
      if (recording.noise_px == 0.0) continue;
      for (int i = 0; i < 2; ++i) {
        view.residual_px[i] += recording.noise_px * random->Normal();
      }
      view.per_sigma = 1.0 / recording.noise_px;
    }
    return views;
  }

  ViewBias Learn(const BodyRecording& recording, bool always) const {
    BiasSeries series(joints_, static_cast<int>(cameras_.size()));
    Random random(5);
    std::vector<int> seen = {hip_};
    if (recording.with_knee) seen.push_back(skeleton_.IndexOf("l_knee"));
    constexpr int kFrames = 600;
    for (int k = 0; k < kFrames; ++k) {
      const BodyStance stance =
          StanceAt(2.0 * kPi * recording.turns * k / kFrames);
      std::vector<BiasSums> sums(classes_.size());
      for (const int joint : seen) {
        const auto views = Views(recording, stance, joint, &random);
        for (const BiasView& view : views) {
          series.AddAzimuth(view.view_idx, view.direction.azimuth);
        }
        AddViews(views, 1.0, &sums[joints_.IndexOf(joint)]);
      }
      series.Add(FromSeconds(0.1 * k), sums);
    }
    if (recording.removes_shifts) series.RemoveShifts();
    return series.Fit(always);
  }

  // 2 cm across and 1.5 cm along the trunk, with two periods per revolution,
  // unlike a constant offset of the joint.
  static ViewBias::OfJoint TwiceAround() {
    ViewBias::OfJoint bias;
    bias.used = true;
    bias.across_m[3] = 0.02;
    bias.along_m[4] = 0.015;
    return bias;
  }

  CameraRig cameras_;
  Skeleton skeleton_;
  BiasJoints joints_;
  int hip_;
  size_t entry_;  // of the hip in ViewBias::joints
  std::vector<JointClass> classes_;
};

TEST_F(ViewBiasTest, EstimatesTheSimulatedBias) {
  BodyRecording recording;
  recording.bias = TwiceAround();
  const ViewBias learnt = Learn(recording, false);
  const ViewBias::OfJoint& hip = learnt.joints[entry_];
  EXPECT_EQ(hip.joint, "hip");
  EXPECT_EQ(hip.observations, 3000);
  EXPECT_TRUE(hip.used);
  EXPECT_NEAR(learnt.azimuth_deg, 360.0, 1e-9);
  // 3000 observations with errors of 8 mm and features with a mean square of
  // 0.5 determine a coefficient to 0.2 mm; the ridge makes it too small by less
  // than 0.1 mm. The tolerance is ten times the former.
  for (size_t i = 0; i < kViewFeatureCount; ++i) {
    if (i >= 7) continue;  // undetermined, as all cameras have the same height
    EXPECT_NEAR(hip.across_m[i], recording.bias.across_m[i], 2e-3) << i;
    EXPECT_NEAR(hip.along_m[i], recording.bias.along_m[i], 2e-3) << i;
  }
  EXPECT_GT(hip.gain, 0.5);  // bias of 14 and 11 mm RMS, noise of 8 mm
}

TEST_F(ViewBiasTest, LearnsNoBiasFromAnUnbiasedDetector) {
  const ViewBias learnt = Learn(BodyRecording(), false);
  EXPECT_FALSE(learnt.joints[entry_].used);
  EXPECT_TRUE(learnt.empty());
}

// A body-fixed offset is unobservable in images, so it remains in the joint's
// position.
TEST_F(ViewBiasTest, BodyFixedOffsetIsNotLearntAsBias) {
  BodyRecording recording;
  recording.offset_m = {0.02, -0.03, 0.03};
  const ViewBias learnt = Learn(recording, true);
  const ViewBias::OfJoint& hip = learnt.joints[entry_];
  EXPECT_TRUE(hip.used);
  double worst = 0.0;
  for (int k = 0; k < 36; ++k) {
    const BodyStance stance = StanceAt(kPi * k / 18.0);
    const auto direction = DirectionOf(joints_, stance, hip_,
                                       Eigen::Vector3d(0, 0, 0.9), cameras_[0]);
    worst = std::max(worst, BiasOf(hip, *direction).norm());
  }
  // An offset of 47 mm is 12 px here. Noise of 2 px causes errors of 0.04 px in
  // each of ten coefficients, and the second order of perspective (f d^2 / z^2)
  // 0.1 px.
  EXPECT_LT(worst, 0.5);
}

// If all people face one way, a bias cannot be distinguished from a shift of
// each camera.
TEST_F(ViewBiasTest, IsUnusedIfAllPeopleFaceOneWay) {
  BodyRecording recording;
  recording.turns = 0.15;
  recording.bias = TwiceAround();
  const ViewBias learnt = Learn(recording, true);
  EXPECT_LT(learnt.azimuth_deg, 90.0);
  EXPECT_TRUE(learnt.empty());
}

// The solution of a body that turns once on the spot in front of `cameras`. The
// left hip, detected 2 px off, is seen by all cameras in the first `shared` of
// the frames, then by each camera in turn, alone.
PersonProblem TurningBody(const Skeleton& skeleton, const CameraRig& cameras,
                          double shared) {
  constexpr int kFrames = 240;
  PersonProblem body;
  body.joints.resize(skeleton.joints().size());
  const auto place = [&](const char* name, const Eigen::Vector3d& point_m) {
    State state = State::Zero();
    state.head<3>() = point_m;
    body.joints[skeleton.IndexOf(name)].states.back() = state;
  };
  JointChain& hip = body.joints[skeleton.IndexOf("l_hip")];
  for (int k = 0; k < kFrames; ++k) {
    body.times.push_back(FromSeconds(0.1 * k));
    for (JointChain& chain : body.joints) chain.states.push_back(State::Zero());
    const double heading = 2.0 * kPi * k / kFrames;
    const Eigen::Vector3d left(-std::sin(heading), std::cos(heading), 0.0);
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d hip_m = 0.15 * left + 0.9 * up;
    place("l_hip", hip_m);
    place("r_hip", -0.15 * left + 0.9 * up);
    place("l_shoulder", 0.2 * left + 1.4 * up);
    place("r_shoulder", -0.2 * left + 1.4 * up);
    const size_t alone = static_cast<size_t>(k) % cameras.size();
    for (size_t v = 0; v < cameras.size(); ++v) {
      if (k >= shared * kFrames && v != alone) continue;
      PixelMeasurement& seen = hip.measurements.emplace_back();
      seen.px = *cameras[v].Project(hip_m) + Eigen::Vector2d(2.0, 0.0);
      seen.camera = &cameras[v];
      seen.weight = 1.0;
    }
    for (JointChain& chain : body.joints) {
      chain.first.push_back(static_cast<int32_t>(chain.measurements.size()));
    }
  }
  return body;
}

// A single view contributes no residual, so its direction must not count.
TEST_F(ViewBiasTest, ASingleViewIsNoViewingDirection) {
  const auto learnt = [this](double shared) {
    BiasSeries series(joints_, static_cast<int>(cameras_.size()));
    AddBiasResiduals(joints_, cameras_, 10.0, ErrorCorrelation{0.0, 0.3},
                     TurningBody(skeleton_, cameras_, shared), &series);
    return series.Fit(true);
  };
  const ViewBias all = learnt(1.0);
  EXPECT_EQ(all.joints[entry_].observations, 5 * 240);
  EXPECT_NEAR(all.azimuth_deg, 360.0, 1e-9);
  EXPECT_TRUE(all.joints[entry_].used);
  const ViewBias quarter = learnt(0.25);
  EXPECT_EQ(quarter.joints[entry_].observations, 5 * 60);
  // 90 degrees, and the sectors at both ends.
  EXPECT_LE(quarter.azimuth_deg, 120.0);
  EXPECT_FALSE(quarter.joints[entry_].used);
}

// Left and right share coefficients, mirrored: left of the left hip corresponds
// to right of the right hip.
TEST_F(ViewBiasTest, LeftAndRightAreMirrored) {
  const ViewBias::OfJoint bias = TwiceAround();
  const Camera& camera = cameras_[0];
  const Eigen::Vector3d point(0, 0, 0.9);
  const Eigen::Vector3d to_camera = camera.centre() - point;
  const double facing = std::atan2(to_camera.y(), to_camera.x());
  const auto of = [&](const char* name, double heading) {
    const int joint = skeleton_.IndexOf(name);
    return BiasOf(
        bias, *DirectionOf(joints_, StanceAt(heading), joint, point, camera));
  };
  const Eigen::Vector2d left = of("l_hip", facing + 0.7);
  const Eigen::Vector2d right = of("r_hip", facing - 0.7);
  EXPECT_GT(left.norm(), 3.0);  // at least 1.5 cm; a pixel is 4 mm
  EXPECT_NEAR(left.x(), -right.x(), 1e-9);
  EXPECT_NEAR(left.y(), right.y(), 1e-9);
}

// The variance of the mean of many independent errors, divided by that of as
// many partly correlated errors, which is summed over all pairs.
TEST(IndependentShareTest, EqualsTheVarianceOfAMean) {
  const ErrorCorrelation correlation{0.8, 0.3};
  constexpr double kPeriod_s = 0.1;
  constexpr int kCount = 3000;
  double sum = kCount;
  for (int lag = 1; lag < kCount; ++lag) {
    sum += 2.0 * (kCount - lag) * correlation.share *
           std::exp(-lag * kPeriod_s / correlation.time_s);
  }
  const double share = IndependentShare(correlation, kPeriod_s);
  // A finite series lacks correlations beyond its ends, about 3 of 3000 errors.
  EXPECT_NEAR(share, kCount / sum, 2e-3 * share);
  EXPECT_EQ(IndependentShare({0.0, 0.3}, kPeriod_s), 1.0);
}

// With known positions the bias follows from least squares.
TEST_F(ViewBiasTest, RecoversTheBiasAtKnownPositions) {
  BiasSums sums;
  BodyRecording recording;
  recording.noise_px = 0.0;
  recording.bias = TwiceAround();
  for (int k = 0; k < 600; ++k) {
    AddViews(Views(recording, StanceAt(0.1 * k), hip_, nullptr), 0.1, &sums);
  }
  EXPECT_NEAR(sums.independent, 0.1 * 3000.0, 1e-9);
  // The ridge of one observation, compared with 300 with a mean square of 0.5,
  // biases by less than 1 % of 2 cm; the tolerance is twice that.
  const auto solved = SolveBias(sums, 1.0);
  EXPECT_NEAR(solved[3], 0.02, 4e-4);
  EXPECT_NEAR(solved[kViewFeatureCount + 4], 0.015, 4e-4);
}

// A hip and a knee at known positions. The images of one camera are shifted; 12
// px correspond to 5 cm.
TEST_F(ViewBiasTest, ImageShiftsAppearAsBiasUnlessRemoved) {
  const auto greatest = [this](const ViewBias& bias) {
    double value = 0.0;
    for (const double one : bias.joints[entry_].across_m) {
      value = std::max(value, std::abs(one));
    }
    return value;
  };
  BodyRecording shifted;
  shifted.turns = 0.3;
  shifted.noise_px = 0.0;
  shifted.with_knee = true;
  shifted.shift_px = {12.0, -7.0};
  const ViewBias unremoved = Learn(shifted, true);
  EXPECT_GT(greatest(unremoved), 5e-3);
  EXPECT_FALSE(unremoved.joints[entry_].used);  // 108 degrees are not enough
  shifted.removes_shifts = true;
  // Rounding errors of sums of 12,000 numbers of the order of a metre.
  EXPECT_LT(greatest(Learn(shifted, true)), 1e-9);
  shifted.bias = TwiceAround();
  EXPECT_TRUE(Learn(shifted, true).joints[entry_].used);
  // Two cameras that see 108 degrees each do not cover 360, however many others
  // see nobody.
  shifted.seeing_cameras = 2;
  EXPECT_FALSE(Learn(shifted, true).joints[entry_].used);
  shifted.seeing_cameras = 5;
  // Removing shifts removes each camera's mean residual. If the body is seen
  // from all sides, that of the bias is zero, apart from differences in
  // distance, so the bias remains.
  shifted.turns = 6.0;
  const ViewBias turning = Learn(shifted, true);
  EXPECT_NEAR(turning.joints[entry_].across_m[3], 0.02, 1e-3);
  EXPECT_TRUE(turning.joints[entry_].used);
}

// Adds observations of one joint, with residuals along one feature.
void AddObservations(size_t entry, double residual_m, size_t names,
                     BiasSeries* series) {
  for (int k = 0; k < 100; ++k) {
    std::vector<BiasSums> sums(names);
    BiasSums& one = sums[entry];
    one.A.diagonal().setOnes();
    one.g[0] = residual_m;
    one.feature_squares.setOnes();
    one.weight = one.square = one.independent = 1.0;
    one.observations = 4;
    one.looks = 1;
    for (int sector = 0; sector < 24; ++sector) {
      series->AddAzimuth(0, -3.1 + 0.26 * sector);
    }
    series->Add(FromSeconds(0.1 * k), sums);
  }
}

TEST_F(ViewBiasTest, BiasOfOnePassIsUsedInTheNext) {
  GraphOptions options;
  options.view_bias = ViewBiasUse::kOn;
  RecordingNotes notes(options);
  EXPECT_EQ(notes.NewSeries(joints_, 1), nullptr);  // not requested
  notes.ExpectAnotherPass();
  const auto first = notes.NewSeries(joints_, 1);
  const auto second = notes.NewSeries(joints_, 1);
  // The order is irrelevant.
  AddObservations(entry_, 0.03, classes_.size(), second.get());
  AddObservations(entry_, 0.01, classes_.size(), first.get());
  EXPECT_EQ(notes.view_bias(), nullptr);
  notes.BeginPass();
  ASSERT_NE(notes.view_bias(), nullptr);
  const ViewBias::OfJoint& learnt = notes.view_bias()->joints[entry_];
  EXPECT_EQ(learnt.observations, 800);
  EXPECT_TRUE(learnt.used);
  // 800 observations, which count as 200 independent ones (BiasSums), of 2 cm
  // on average, with a ridge of ten; the position absorbs three of the eight
  // pixel coordinates of four views.
  EXPECT_NEAR(learnt.across_m[0], 0.02 * 200.0 / 210.0 * 8.0 / 5.0, 1e-12);
  EXPECT_EQ(notes.NewSeries(joints_, 1), nullptr);  // already added
}

// Sigmas and process noise are combined by geometric means, shares, times and
// powers by arithmetic means, limits by the least and the greatest value.
TEST(RecordingNotesTest, WeightsPeopleByJointsSeen) {
  RecordingNotes notes((GraphOptions()));
  const auto knee = static_cast<size_t>(JointClass::kKnee);
  const auto one = notes.NewPerson();
  one->classes[knee] = {300, 2.0, 1.0, 0.5, 4.0};
  one->correlation = {0.9, 0.1};
  one->confidence_power = 1.0;
  const auto other = notes.NewPerson();
  other->classes[knee] = {100, 32.0, 16.0, 0.25, 64.0};
  other->correlation = {0.5, 0.3};
  const auto nobody = notes.NewPerson();
  const LearntNoise all = notes.Noise();
  EXPECT_EQ(all.classes[knee].joints_seen, 400);
  EXPECT_NEAR(all.classes[knee].sigma_px, 4.0, 1e-9);  // 2^(3/4) 32^(1/4)
  EXPECT_NEAR(all.classes[knee].process_noise, 2.0, 1e-9);
  EXPECT_EQ(all.classes[knee].least_process_noise, 0.25);
  EXPECT_EQ(all.classes[knee].greatest_process_noise, 64.0);
  EXPECT_NEAR(all.correlation.share, 0.8, 1e-9);
  EXPECT_NEAR(all.correlation.time_s, 0.15, 1e-9);
  EXPECT_NEAR(all.confidence_power, 0.75, 1e-9);
  EXPECT_EQ(ToJson(all),
            "{\"error_time_s\": 0.15, \"error_share\": 0.8, "
            "\"confidence_power\": 0.75, \"classes\": {\"knee\": "
            "{\"joints_seen\": 400, \"sigma_px\": 4, "
            "\"process_noise\": 2, \"least_process_noise\": 0.25, "
            "\"greatest_process_noise\": 64}}}");
}

}  // namespace
}  // namespace kinegraph
