// Tests segments of joints with exactly known motion.
#include "solvers/cameras/segments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// ---- One segment ----

SegmentState StateOf(const Eigen::Vector3d& position_m,
                     const Eigen::Vector3d& velocity_mps,
                     const Eigen::Vector3d& acceleration_mps2) {
  SegmentState state;
  state << position_m, velocity_mps, acceleration_mps2;
  return state;
}

SegmentState Falling() {
  return StateOf({0.3, -0.2, 1.1}, {0.8, -0.5, 0.3}, {0.4, 0.2, -9.81});
}

// The projections of a state in six frames, a fifth of a second.
MotionSegment SegmentOf(const CameraRig& cameras, const SegmentState& state) {
  MotionSegment segment;
  segment.state = state;
  for (size_t v = 0; v < cameras.size(); ++v) {
    for (int k = 0; k < 6; ++k) {
      SegmentMeasurement measurement;
      measurement.view_idx = static_cast<int>(v);
      const double t = 0.04 * (k - 2.5);
      measurement.time_s = t;
      measurement.px =
          *cameras[v].Project(state.head<3>() + t * state.segment<3>(3) +
                              0.5 * t * t * state.tail<3>());
      measurement.sigma_px = 6.0;
      segment.measurements.push_back(measurement);
    }
  }
  return segment;
}

// Options with negligible priors on velocity and acceleration.
SegmentOptions WithoutPriors() {
  SegmentOptions options;
  options.velocity_sigma_mps = 1e6;
  options.acceleration_sigma_mps2 = 1e6;
  return options;
}

TEST(SegmentPrior, ConstrainsVelocityAndAcceleration) {
  SegmentOptions options;
  options.velocity_sigma_mps = 5.0;
  options.acceleration_sigma_mps2 = 20.0;
  const SegmentState prior = PriorInformation(options);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(prior[i], 0.0);
    EXPECT_DOUBLE_EQ(prior[3 + i], 0.04);
    EXPECT_DOUBLE_EQ(prior[6 + i], 0.0025);
  }
}

// The camera's clock is late by its offset plus its drift times the time since
// the middle of the recording.
TEST(SegmentResidual, UsesTheParabolaAtTheCorrectedTime) {
  const CameraRig cameras = testing::RingOfCameras(1);
  MotionSegment segment;
  segment.middle_s = 20.0;
  SegmentMeasurement measurement;
  measurement.time_s = 0.05;
  measurement.px = {940.0, 560.0};
  measurement.sigma_px = 4.0;
  CameraChange change = CameraChange::Zero();
  change[kOffsetAt] = 0.03;
  change[kDriftAt] = 1e-3;
  const SegmentState state = Falling();
  const double tau = 0.05 + 0.03 + 1e-3 * 20.05;
  const Eigen::Vector3d point(0.3 + 0.8 * tau + 0.2 * tau * tau,
                              -0.2 - 0.5 * tau + 0.1 * tau * tau,
                              1.1 + 0.3 * tau - 4.905 * tau * tau);
  const Eigen::Vector2d expected =
      (*cameras[0].Project(point) - measurement.px) / (4.0 * 1.5);
  const auto residual =
      SegmentResidual(cameras[0], change, segment, state, measurement, 1.5);
  ASSERT_TRUE(residual.has_value());
  // Pixel coordinates near 1000 are rounded to 1e-13 in each of a few
  // operations.
  EXPECT_LT((*residual - expected).norm(), 1e-12);
}

TEST(SegmentResidual, IsUndefinedBehindTheCamera) {
  const CameraRig cameras = testing::RingOfCameras(1);
  // The camera stands at (5, 0, 2).
  const SegmentState behind =
      StateOf({9.0, 0.0, 2.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0});
  EXPECT_FALSE(SegmentResidual(cameras[0], CameraChange::Zero(),
                               MotionSegment(), behind, SegmentMeasurement(),
                               1.0)
                   .has_value());
  MotionSegment segment;
  segment.measurements.resize(1);
  EXPECT_THAT(TermsOf(cameras, NoChanges(1), segment, behind, 1.0), IsEmpty());
}

// Central differences use a step of 1e-5. Residuals of a hundred have rounding
// errors of 1e-14, which the step amplifies to 1e-9; third derivatives of about
// a thousand give errors of 1e-8. The tolerance is a hundred times the latter.
TEST(SegmentResidual, JacobiansMatchNumericDerivatives) {
  const CameraRig cameras =
      testing::RingOfCameras(1, 5.0, {-0.1, 0.02, 0.001, -0.0005, 0.0});
  MotionSegment segment;
  segment.middle_s = 3.0;
  SegmentMeasurement measurement;
  measurement.time_s = 0.07;
  measurement.sigma_px = 4.0;
  CameraChange change = CameraChange::Zero();
  change << 0.01, -0.02, 0.015, 0.02, -0.01, 0.03, 4.0, -3.0, 0.02, 0.03, 1e-3,
      0.01, 0.005;
  const SegmentState state = Falling();
  const auto at = [&](const SegmentState& s, const CameraChange& c) {
    return *SegmentResidual(cameras[0], c, segment, s, measurement, 1.2);
  };
  Eigen::Matrix<double, 2, kSegmentSize> by_state;
  Eigen::Matrix<double, 2, kChangeSize> by_change;
  SegmentResidual(cameras[0], change, segment, state, measurement, 1.2,
                  &by_state, &by_change);
  constexpr double kStep = 1e-5;
  constexpr double kError = 1e-6;
  for (int i = 0; i < kSegmentSize; ++i) {
    const SegmentState step = kStep * SegmentState::Unit(i);
    const Eigen::Vector2d slope =
        (at(state + step, change) - at(state - step, change)) / (2.0 * kStep);
    EXPECT_LT((by_state.col(i) - slope).norm(), kError) << i;
  }
  for (int i = 0; i < kChangeSize; ++i) {
    const CameraChange step = kStep * CameraChange::Unit(i);
    const Eigen::Vector2d slope =
        (at(state, change + step) - at(state, change - step)) / (2.0 * kStep);
    EXPECT_LT((by_change.col(i) - slope).norm(), kError) << i;
  }
}

// The weight of the Cauchy loss with a scale of two sigmas is 1 / (1 + s / 4),
// where s is the squared residual.
TEST(SegmentTerms, HaveLossWeights) {
  const CameraRig cameras = testing::RingOfCameras(2);
  MotionSegment segment = SegmentOf(cameras, Falling());
  segment.measurements[3].px += Eigen::Vector2d(0.0, 12.0);
  const auto terms =
      TermsOf(cameras, NoChanges(2), segment, segment.state, 1.0);
  ASSERT_EQ(terms.size(), 12u);
  for (size_t i = 0; i < terms.size(); ++i) {
    EXPECT_EQ(terms[i].view, i / 6);
    // Twelve pixels are two sigmas.
    EXPECT_NEAR(terms[i].residual.norm(), i == 3 ? 2.0 : 0.0, 1e-12);
    EXPECT_NEAR(terms[i].weight, i == 3 ? 0.5 : 1.0, 1e-12);
  }
}

// The iteration stops at steps below 1e-5 m; for an exact fit, the last
// Gauss-Newton step squares the remaining error.
TEST(SolveSegment, RecoversTheParabola) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const MotionSegment segment = SegmentOf(cameras, Falling());
  SegmentState state = SegmentState::Zero();
  state.head<3>() = Eigen::Vector3d(0.33, -0.22, 1.12);
  ASSERT_TRUE(SolveSegment(cameras, NoChanges(3), segment, 1.0, WithoutPriors(),
                           &state));
  EXPECT_LT((state.head<3>() - Falling().head<3>()).norm(), 1e-6);
  // The effect of a position error of 1e-6 m over 0.1 s.
  EXPECT_LT((state.segment<3>(3) - Falling().segment<3>(3)).norm(), 1e-5);
  EXPECT_LT((state.tail<3>() - Falling().tail<3>()).norm(), 1e-3);
}

// For a joint at rest the priors are exact.
TEST(SolveSegment, RecoversAJointAtRestWithPriors) {
  const CameraRig cameras = testing::RingOfCameras(3);
  SegmentState rest = SegmentState::Zero();
  rest.head<3>() = Eigen::Vector3d(-0.4, 0.1, 0.9);
  const MotionSegment segment = SegmentOf(cameras, rest);
  SegmentState state = rest;
  state.head<3>() += Eigen::Vector3d(0.02, -0.03, 0.01);
  ASSERT_TRUE(SolveSegment(cameras, NoChanges(3), segment, 1.0,
                           SegmentOptions(), &state));
  EXPECT_LT((state - rest).norm(), 1e-6);
}

// A clock offset shifts the parabola in time.
TEST(SolveSegment, AppliesClockChanges) {
  const CameraRig cameras = testing::RingOfCameras(3);
  MotionSegment segment = SegmentOf(cameras, Falling());
  std::vector<CameraChange> changes = NoChanges(3);
  changes[1][kOffsetAt] = 0.015;
  for (SegmentMeasurement& one : segment.measurements) {
    if (one.view_idx == 1) one.time_s -= 0.015;
  }
  SegmentState state = Falling();
  state.head<3>().array() += 0.02;
  ASSERT_TRUE(
      SolveSegment(cameras, changes, segment, 1.0, WithoutPriors(), &state));
  EXPECT_LT((state.head<3>() - Falling().head<3>()).norm(), 1e-6);
}

// Without measurements the position is kept and the velocity becomes zero; with
// one view the initial depth is kept.
TEST(SolveSegment, UnmeasuredDirectionsKeepTheInitialPosition) {
  const CameraRig cameras = testing::RingOfCameras(1);
  MotionSegment nothing;
  SegmentState state = Falling();
  ASSERT_TRUE(SolveSegment(cameras, NoChanges(1), nothing, 1.0,
                           SegmentOptions(), &state));
  EXPECT_LT((state.head<3>() - Falling().head<3>()).norm(), 1e-12);
  EXPECT_LT(state.tail<6>().norm(), 1e-12);
  SegmentState rest = SegmentState::Zero();
  rest.head<3>() = Eigen::Vector3d(-0.4, 0.1, 0.9);
  const MotionSegment one_view = SegmentOf(cameras, rest);
  state = rest;
  state.head<3>() += 0.3 * (cameras[0].centre() - rest.head<3>()).normalized();
  const SegmentState start = state;
  ASSERT_TRUE(SolveSegment(cameras, NoChanges(1), one_view, 1.0,
                           SegmentOptions(), &state));
  EXPECT_LT((state - start).norm(), 1e-6);
}

// ---- Detections ----

TEST(FindDetectionTest, FindsByIndexInFile) {
  ViewDetections view;
  EXPECT_EQ(FindDetection(view, 0), nullptr);
  view.detections.resize(3);
  view.detections[0].index_in_file = 5;
  view.detections[1].index_in_file = 2;
  EXPECT_EQ(FindDetection(view, 2), &view.detections[1]);
  EXPECT_EQ(FindDetection(view, 5), &view.detections[0]);
  EXPECT_EQ(FindDetection(view, 1), nullptr);
}

DetectionSequence OneDetection(const std::vector<double>& confidences) {
  DetectionSequence detections;
  detections.frames.resize(1);
  detections.frames[0].views.resize(1);
  Detection& one =
      detections.frames[0].views[0].detections.emplace_back(Detection());
  for (const double confidence : confidences) {
    one.joints.push_back({{1.0, 2.0}, confidence, confidence >= 0.0});
  }
  return detections;
}

std::vector<double> UsualConfidences(const std::vector<double>& confidences) {
  const DetectionSequence usual =
      WithUsualConfidences(OneDetection(confidences));
  std::vector<double> result;
  for (const Keypoint& joint : usual.frames[0].views[0].detections[0].joints) {
    if (joint.found) result.push_back(joint.confidence);
  }
  return result;
}

// Medians of zero or of at least 0.6 are left as they are.
TEST(UsualConfidences, LowMediansAreScaledToSixTenths) {
  using ::testing::DoubleEq;
  EXPECT_THAT(UsualConfidences({0.1, 0.3, 0.4, -1.0, -1.0, -1.0}),
              ElementsAre(DoubleEq(0.2), DoubleEq(0.6), DoubleEq(0.8)));
  EXPECT_THAT(UsualConfidences({0.2, 0.7, 0.9}), ElementsAre(0.2, 0.7, 0.9));
  EXPECT_THAT(UsualConfidences({0.0, 0.0, 0.9}), ElementsAre(0.0, 0.0, 0.9));
  EXPECT_THAT(UsualConfidences({}), IsEmpty());
}

// ---- The segments of a recording ----

constexpr int kWalkFrames = 50;
const Eigen::Vector3d kWalkMps(0.6, -0.4, 0.0);

// A person whose joints all move with the same velocity.
Pose3d Glider(double time_s) {
  Pose3d pose = testing::StandingPerson(-0.6, 0.4);
  for (Joint3d& joint : pose) joint.position_m += time_s * kWalkMps;
  return pose;
}

DetectionSequence GliderSeenBy(const CameraRig& cameras) {
  return testing::SeenBy(cameras, kWalkFrames, [](int frame) {
    return std::vector<Pose3d>{Glider(0.04 * frame)};
  });
}

// Matches of the first detections of all views.
FrozenMatches MatchedEverywhere(const DetectionSequence& seen) {
  FrozenMatches matches;
  FrozenPerson& person = matches.people.emplace_back();
  for (const DetectionFrame& frame : seen.frames) {
    FrozenFrame& frozen = person.frames.emplace_back();
    frozen.frame = frame.frame;
    frozen.time = frame.time;
    for (size_t v = 0; v < frame.views.size(); ++v) {
      frozen.detections.push_back({static_cast<int>(v), 0});
    }
  }
  return matches;
}

// Six frames span a fifth of a second, so each of 17 joints has eight segments
// and one with the last two frames.
TEST(MakeSegments, MakesSegmentsOfEveryJointOverTheWholeRecording) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const DetectionSequence seen = GliderSeenBy(cameras);
  const SceneSegments made =
      MakeSegments(cameras, seen, MatchedEverywhere(seen), SegmentOptions());
  EXPECT_EQ(made.view_count, 3);
  EXPECT_DOUBLE_EQ(made.span_s, 1.96);
  EXPECT_DOUBLE_EQ(made.frame_s, 0.04);
  ASSERT_EQ(made.classes.size(), 17u);
  EXPECT_EQ(made.classes[5], JointClass::kShoulder);
  ASSERT_EQ(made.segments.size(), 9u * 17u);
  std::set<std::pair<int, int>> found;
  for (const MotionSegment& one : made.segments) {
    // Times are relative to the middle of the recording, at 0.98 s.
    const int run =
        static_cast<int>(std::lround((one.middle_s + 0.98) / 0.24 - 0.1));
    found.insert({run, one.joint});
    const int frames = run < 8 ? 6 : 2;
    const double middle_s = 0.24 * run + 0.02 * (frames - 1);
    EXPECT_NEAR(one.middle_s, middle_s - 0.98, 1e-9);
    EXPECT_EQ(one.measurements.size(), 3u * frames);
    EXPECT_EQ(one.person, 0);
    // The prior biases the velocity towards zero by the ratio of the variances.
    const double bias = std::pow(
        one.velocity_sigma_mps / SegmentOptions().velocity_sigma_mps, 2);
    EXPECT_LT((one.state.segment<3>(3) - kWalkMps).norm(),
              3.0 * bias * kWalkMps.norm());
    // Samples are symmetric about the middle, so the bias of the velocity
    // affects the position only through the change of depth, at most 7 cm of
    // 5 m. The tolerance is that bias over half a segment, 0.1 s.
    EXPECT_LT((PositionOf(one) - Glider(middle_s)[one.joint].position_m).norm(),
              0.1 * 3.0 * bias * kWalkMps.norm() + 1e-6);
  }
  EXPECT_EQ(found.size(), made.segments.size());
  EXPECT_TRUE(std::is_sorted(made.segments.begin(), made.segments.end(),
                             [](const auto& a, const auto& b) {
                               return a.middle_s < b.middle_s - 1e-9;
                             }));
}

TEST(MakeSegments, LimitedSegmentsAreSpreadOverTimeAndJoints) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const DetectionSequence seen = GliderSeenBy(cameras);
  SegmentOptions options;
  options.max_segments = 51;
  const SceneSegments made =
      MakeSegments(cameras, seen, MatchedEverywhere(seen), options);
  // Every third of 153 segments.
  EXPECT_EQ(made.segments.size(), 51u);
  std::map<double, int> of_time;
  for (const MotionSegment& one : made.segments) ++of_time[one.middle_s];
  EXPECT_EQ(of_time.size(), 9u);
  for (const auto& [middle_s, count] : of_time) {
    EXPECT_NEAR(count, 17.0 / 3.0, 1.0);
  }
}

TEST(MakeSegments, GapsEndASegment) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const DetectionSequence seen = GliderSeenBy(cameras);
  FrozenMatches matches = MatchedEverywhere(seen);
  auto& frames = matches.people[0].frames;
  frames.resize(6);
  // Of the first six frames, which span a fifth of a second, frame 3 is
  // missing.
  frames.erase(frames.begin() + 3);
  const SceneSegments made =
      MakeSegments(cameras, seen, matches, SegmentOptions());
  EXPECT_EQ(made.segments.size(), 2u * 17u);
  for (const MotionSegment& one : made.segments) {
    EXPECT_EQ(one.measurements.size(), one.middle_s < 0.1 - 0.98 ? 9u : 6u);
  }
}

TEST(MakeSegments, JointsInASingleViewOrWithLowConfidenceAreOmitted) {
  const CameraRig ring = testing::RingOfCameras(3);
  const CameraRig cameras = {ring[0], ring[1]};
  DetectionSequence seen = GliderSeenBy(cameras);
  for (DetectionFrame& frame : seen.frames) {
    frame.views[1].detections[0].joints[9].found = false;
    frame.views[0].detections[0].joints[11].confidence = 0.29;
  }
  const SceneSegments made =
      MakeSegments(cameras, seen, MatchedEverywhere(seen), SegmentOptions());
  EXPECT_EQ(made.segments.size(), 9u * 15u);
  for (const MotionSegment& one : made.segments) {
    EXPECT_NE(one.joint, 9);
    EXPECT_NE(one.joint, 11);
  }
}

TEST(MakeSegments, NoSegmentsWithoutMatchesOrFrames) {
  const CameraRig cameras = testing::RingOfCameras(3);
  DetectionSequence seen = GliderSeenBy(cameras);
  const SceneSegments none =
      MakeSegments(cameras, seen, FrozenMatches(), SegmentOptions());
  EXPECT_THAT(none.segments, IsEmpty());
  EXPECT_EQ(none.noise_scale, 1.0);
  EXPECT_THAT(none.matched, ElementsAre(0, 0, 0));
  // Matches in frames that the recording does not contain.
  FrozenMatches elsewhere = MatchedEverywhere(seen);
  for (FrozenFrame& frame : elsewhere.people[0].frames) frame.frame += 1000;
  EXPECT_THAT(MakeSegments(cameras, seen, elsewhere, SegmentOptions()).segments,
              IsEmpty());
  const FrozenMatches matches = MatchedEverywhere(seen);
  seen.frames.clear();
  const SceneSegments empty =
      MakeSegments(cameras, seen, matches, SegmentOptions());
  EXPECT_THAT(empty.segments, IsEmpty());
  EXPECT_EQ(empty.view_count, 3);
}

// A view is counted in the frames in which two other views match a person. One
// of two people is matched: in the first frame by all views, in the second by
// the last two of three, in the third by the first view only.
TEST(MakeSegments, CountsMatchesIfTwoOtherViewsMatch) {
  const CameraRig cameras = testing::RingOfCameras(3);
  DetectionSequence seen = testing::SeenBy(cameras, 3, [](int) {
    return std::vector<Pose3d>{Glider(0.0), Glider(1.0)};
  });
  FrozenMatches matches = MatchedEverywhere(seen);
  auto& frames = matches.people[0].frames;
  frames[1].detections.erase(frames[1].detections.begin());
  frames[2].detections.resize(1);
  const SceneSegments made =
      MakeSegments(cameras, seen, matches, SegmentOptions());
  EXPECT_THAT(made.matched, ElementsAre(1, 1, 1));
  // The first view could have matched this person in the second frame, too. Its
  // other detection, which no view matches, does not count.
  EXPECT_THAT(made.matchable, ElementsAre(2, 1, 1));
}

// Residuals of exact detections of people at rest are rounding errors.
TEST(MakeSegments, NoiseScaleOfExactDetectionsIsPositive) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const DetectionSequence seen = testing::SeenBy(
      cameras, 50, [](int) { return std::vector<Pose3d>{Glider(0.0)}; });
  const SceneSegments made =
      MakeSegments(cameras, seen, MatchedEverywhere(seen), SegmentOptions());
  EXPECT_GE(made.noise_scale, 1e-6);
  EXPECT_FALSE(made.segments.empty());
}

// ---- Properties of sets of segments ----

MotionSegment MovingSegment(double speed_mps, double velocity_sigma_mps) {
  MotionSegment segment;
  segment.state[4] = speed_mps;
  segment.velocity_sigma_mps = velocity_sigma_mps;
  return segment;
}

// All segments have the same speed, which is then every quantile.
bool MoveEnoughAt(double speed_mps, double sigma_mps, double noise_scale) {
  SceneSegments segments;
  segments.segments.assign(10, MovingSegment(speed_mps, sigma_mps));
  segments.noise_scale = noise_scale;
  return MoveEnough(segments);
}

TEST(MoveEnough, RequiresSpeedAndCertainty) {
  EXPECT_TRUE(MoveEnoughAt(0.31, 0.01, 1.0));
  EXPECT_FALSE(MoveEnoughAt(0.29, 0.01, 1.0));
  EXPECT_TRUE(MoveEnoughAt(1.0, 0.19, 1.0));
  EXPECT_FALSE(MoveEnoughAt(1.0, 0.21, 1.0));
  EXPECT_FALSE(MoveEnoughAt(1.0, 0.19, 2.0));
  EXPECT_TRUE(MoveEnoughAt(1.0, 0.39, 0.5));
  EXPECT_FALSE(MoveEnough(SceneSegments()));
}

// Ten of 101 segments have the indices 91 to 100 in sorted order; the quantile
// has the index 90.
TEST(MoveEnough, RequiresATenthOfTheSegments) {
  SceneSegments segments;
  segments.segments.assign(101, MovingSegment(0.0, 0.01));
  for (int i = 0; i < 10; ++i) segments.segments[i] = MovingSegment(1.0, 0.01);
  EXPECT_FALSE(MoveEnough(segments));
  segments.segments[10] = MovingSegment(1.0, 0.01);
  EXPECT_TRUE(MoveEnough(segments));
}

TEST(BinLengthTest, IsATwentiethWithinBounds) {
  SceneSegments segments;
  const std::vector<std::pair<double, double>> lengths = {
      {0.0, 0.2}, {4.0, 0.2}, {10.0, 0.5}, {20.0, 1.0}, {3600.0, 1.0}};
  for (const auto& [span_s, bin_s] : lengths) {
    segments.span_s = span_s;
    EXPECT_DOUBLE_EQ(BinLength(segments), bin_s) << span_s;
  }
}

// Segments with given person, joint and x coordinate, in temporal order.
SceneSegments HandMade() {
  SceneSegments scene;
  scene.view_count = 3;
  for (int j = 0; j < 17; ++j) {
    scene.classes.push_back(Coco17().joint_class(j));
  }
  const auto add = [&](int person, int joint, double x_m) {
    MotionSegment& one = scene.segments.emplace_back();
    one.person = person;
    one.joint = joint;
    one.middle_s = static_cast<double>(scene.segments.size());
    one.state[0] = x_m;
    for (const int v : {0, 1, 2}) {
      one.measurements.emplace_back();
      one.measurements.back().view_idx = v;
    }
  };
  add(0, 5, 0.0);
  add(0, 6, 0.0);
  add(1, 15, 4.0);
  add(1, 16, 4.0);
  add(2, 5, 1.0);
  add(2, 15, 5.0);
  return scene;
}

// Numbers of the segments in a half.
std::vector<int> InHalf(const SceneSegments& scene, Halving halving, int half) {
  std::vector<int> numbers;
  for (const MotionSegment& one : HalfOf(scene, halving, half).segments) {
    numbers.push_back(static_cast<int>(one.middle_s));
  }
  return numbers;
}

TEST(HalfOf, TimeIsHalvedInTheMiddle) {
  EXPECT_THAT(InHalf(HandMade(), Halving::kTime, 0), ElementsAre(1, 2, 3));
  EXPECT_THAT(InHalf(HandMade(), Halving::kTime, 1), ElementsAre(4, 5, 6));
}

// The shoulders are one pair, the ankles the next.
TEST(HalfOf, JointsAreHalvedInPairs) {
  EXPECT_THAT(InHalf(HandMade(), Halving::kJoints, 0), ElementsAre(1, 2, 5));
  EXPECT_THAT(InHalf(HandMade(), Halving::kJoints, 1), ElementsAre(3, 4, 6));
}

TEST(HalfOf, LegsAreTheFirstHalfOfTheBody) {
  EXPECT_THAT(InHalf(HandMade(), Halving::kBody, 0), ElementsAre(3, 4, 6));
  EXPECT_THAT(InHalf(HandMade(), Halving::kBody, 1), ElementsAre(1, 2, 5));
}

TEST(HalfOf, PeopleAlternateBetweenHalves) {
  EXPECT_THAT(InHalf(HandMade(), Halving::kPeople, 0), ElementsAre(1, 2, 5, 6));
  EXPECT_THAT(InHalf(HandMade(), Halving::kPeople, 1), ElementsAre(3, 4));
}

// Relative to the means of their joints, 0.5 for joint 5 and 4.5 for joint 15,
// two segments are half a metre on one side, two on the other, and the segments
// of joints 6 and 16 are in the middle.
TEST(HalfOf, PositionsAreHalvedInAnyWorldFrame) {
  for (const double angle : {0.0, 1.0, 2.5}) {
    SceneSegments scene = HandMade();
    for (MotionSegment& one : scene.segments) {
      one.state.head<3>() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
                                one.state.head<3>() +
                            Eigen::Vector3d(3.0, -2.0, 1.0);
    }
    const auto first = InHalf(scene, Halving::kPlaces, 0);
    const auto second = InHalf(scene, Halving::kPlaces, 1);
    EXPECT_EQ(first.size() + second.size(), 6u);
    const auto is_in = [](const std::vector<int>& half, int number) {
      return std::find(half.begin(), half.end(), number) != half.end();
    };
    // The sign of the direction is arbitrary.
    EXPECT_EQ(is_in(first, 1), is_in(first, 3));
    EXPECT_EQ(is_in(first, 5), is_in(first, 6));
    EXPECT_NE(is_in(first, 1), is_in(first, 5));
  }
}

TEST(HalfOf, HalvesAreEmptyWithoutSegments) {
  SceneSegments none = HandMade();
  none.segments.clear();
  for (const Halving halving :
       {Halving::kTime, Halving::kJoints, Halving::kBody, Halving::kPlaces,
        Halving::kPeople}) {
    for (const int half : {0, 1}) {
      const SceneSegments part = HalfOf(none, halving, half);
      EXPECT_THAT(part.segments, IsEmpty());
      EXPECT_EQ(part.view_count, 3);
    }
  }
}

// Nine positions of one joint along a line, 0.1 m apart, of which the third and
// the seventh are the quartiles.
TEST(PlacesApartTest, IsTheInterquartileRange) {
  SceneSegments scene = HandMade();
  const MotionSegment one = scene.segments.front();
  EXPECT_EQ(PlacesApart(SceneSegments()), 0.0);
  const Eigen::Vector3d along = Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
  scene.segments.assign(9, one);
  for (int i = 0; i < 9; ++i) {
    scene.segments[i].state.head<3>() =
        Eigen::Vector3d(3.0, -2.0, 1.0) + 0.1 * ((4 * i) % 9) * along;
  }
  EXPECT_NEAR(PlacesApart(scene), 0.4, 1e-12);
  // Segments seen by only two of three views do not count.
  MotionSegment far = one;
  far.state.head<3>() = Eigen::Vector3d(3.0, -2.0, 1.0) + 100.0 * along;
  far.measurements.pop_back();
  scene.segments.push_back(far);
  EXPECT_NEAR(PlacesApart(scene), 0.4, 1e-12);
  // If the recording has only two views, the segment counts. This tenth
  // position changes the mean, and the quartiles have the indices 2.25 and 6.75
  // among the ten.
  scene.view_count = 2;
  EXPECT_NEAR(PlacesApart(scene), 0.45, 1e-9);
}

}  // namespace
}  // namespace kinegraph
