// Tests errors of the fit of cameras to segments in hand-computed cases.
#include "solvers/cameras/fit_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/support/faulty_scene.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

// Two cameras side by side, a metre apart, so that image rows correspond.
CameraRig LeftAndRight() {
  CameraRig cameras;
  for (const double x_m : {0.0, 1.0}) {
    CameraParameters p;
    p.K << 1000.0, 0.0, 960.0, 0.0, 1000.0, 540.0, 0.0, 0.0, 1.0;
    p.t = Eigen::Vector3d(-x_m, 0.0, 0.0);
    cameras.emplace_back(p);
  }
  return cameras;
}

// A joint at rest midway between the two cameras, at a depth of 5 m, in five
// frames. In the second view it is `down_px` lower.
MotionSegment RestingJoint(const CameraRig& cameras, double down_px,
                           double middle_s = 0.0) {
  MotionSegment segment;
  segment.middle_s = middle_s;
  segment.state.head<3>() = Eigen::Vector3d(0.5, 0.0, 5.0);
  for (size_t v = 0; v < cameras.size(); ++v) {
    for (int k = 0; k < 5; ++k) {
      SegmentMeasurement& one = segment.measurements.emplace_back();
      one.view_idx = static_cast<int>(v);
      one.time_s = 0.04 * (k - 2);
      one.px = cameras[v]
                   .Project(segment.state.head<3>())
                   .value_or(Eigen::Vector2d(0.0, 0.0));
      if (v == 1) one.px.y() += down_px;
      one.sigma_px = 60.0;
    }
  }
  return segment;
}

SceneSegments SceneOf(std::vector<MotionSegment> segments, double span_s) {
  SceneSegments scene;
  scene.view_count = 2;
  scene.span_s = span_s;
  scene.segments = std::move(segments);
  return scene;
}

FitError FitOfRest(const CameraRig& cameras,
                   const std::vector<MotionSegment>& segments,
                   double span_s = 10.0) {
  return MeasureFit(cameras, SceneOf(segments, span_s),
                    NoChanges(cameras.size()), SegmentOptions());
}

// ---- Errors ----

// Bins are half a second long; empty bins have no column.
TEST(FilledBinsTest, AreTheBinsWithSegments) {
  const CameraRig cameras = LeftAndRight();
  std::vector<MotionSegment> segments;
  for (const double middle_s : {-4.9, -4.6, -0.1, 0.0, 0.4, 0.5, 3000.2}) {
    segments.push_back(RestingJoint(cameras, 0.0, middle_s));
  }
  EXPECT_THAT(FilledBins(SceneOf(segments, 10.0)),
              ElementsAre(Pair(-10, 0), Pair(-1, 1), Pair(0, 2), Pair(1, 3),
                          Pair(6000, 4)));
  EXPECT_THAT(FilledBins(SceneOf({}, 10.0)), IsEmpty());
}

// The joint is estimated midway, so each view has half of the difference as
// error; distances are capped at 30 px. The iteration ends with a step below
// 1e-5 m, 0.002 px, after which the error is far smaller.
TEST(MeasureFit, IsHalfOfTheDifferenceOfTwoViews) {
  const CameraRig cameras = LeftAndRight();
  for (const double down_px : {0.0, 8.0, -20.0, 59.0, 80.0}) {
    const FitError error = FitOfRest(cameras, {RestingJoint(cameras, down_px)});
    const double expected_px = std::min(30.0, 0.5 * std::abs(down_px));
    for (const int view : {-1, 0, 1}) {
      EXPECT_NEAR(error.MeanPx(view), expected_px, 1e-3) << down_px;
    }
    // The error persists over the segment; converted at 5 m and a focal length
    // of 1000 px.
    for (const size_t view : {0u, 1u}) {
      EXPECT_NEAR(error.LastingM(view), expected_px * 5.0 / 1000.0, 1e-5);
    }
  }
}

// Errors that cancel within a segment are not persistent.
TEST(MeasureFit, CancellingErrorsAreNotPersistent) {
  const CameraRig cameras = LeftAndRight();
  MotionSegment segment = RestingJoint(cameras, 0.0);
  // The errors are symmetric about the middle and have zero mean, so neither a
  // position nor a velocity fits them in the four frames of the second view;
  // the prior excludes accelerations.
  segment.measurements.erase(segment.measurements.begin() + 7);
  const std::vector<double> off_px = {3.0, -3.0, -3.0, 3.0};
  for (int k = 0; k < 4; ++k) segment.measurements[5 + k].px.x() += off_px[k];
  SegmentOptions options;
  options.acceleration_sigma_mps2 = 1e-6;
  const FitError error =
      MeasureFit(cameras, SceneOf({segment}, 10.0), NoChanges(2), options);
  EXPECT_NEAR(error.MeanPx(1), 3.0, 1e-3);
  EXPECT_NEAR(error.LastingM(1), 0.0, 1e-5);
}

// A shift of the second camera's image explains the error of its view.
TEST(MeasureFit, AppliesCameraChanges) {
  const CameraRig cameras = LeftAndRight();
  std::vector<CameraChange> changes = NoChanges(2);
  changes[1][kShiftAt + 1] = 8.0;
  const FitError error =
      MeasureFit(cameras, SceneOf({RestingJoint(cameras, 8.0)}, 10.0), changes,
                 SegmentOptions());
  EXPECT_NEAR(error.MeanPx(), 0.0, 1e-3);
}

// In a third camera that faces away, joints without an image count 30 px and
// have no persistent error.
TEST(MeasureFit, JointsWithoutAnImageCountTheCap) {
  CameraRig cameras = LeftAndRight();
  cameras.push_back(Edited(cameras[0], [](CameraParameters* camera) {
    camera->R = Eigen::Vector3d(-1.0, 1.0, -1.0).asDiagonal();
  }));
  const FitError error = FitOfRest(cameras, {RestingJoint(cameras, 0.0)});
  EXPECT_NEAR(error.MeanPx(0), 0.0, 1e-3);
  EXPECT_EQ(error.MeanPx(2), 30.0);
  EXPECT_NEAR(error.MeanPx(), 10.0, 1e-3);
  EXPECT_EQ(error.segments[2], 0.0);
  EXPECT_EQ(error.LastingM(2), 0.0);
}

// Two segments with errors of 4 px in the first bin, one with 10 px in the
// second.
TEST(MeasureFit, SumsByTimeBin) {
  const CameraRig cameras = LeftAndRight();
  const FitError error = FitOfRest(cameras, {RestingJoint(cameras, 8.0, 0.1),
                                             RestingJoint(cameras, 8.0, 0.2),
                                             RestingJoint(cameras, 20.0, 0.6)});
  ASSERT_EQ(error.sum_px.rows(), 2);
  ASSERT_EQ(error.sum_px.cols(), 2);
  for (const int view : {0, 1}) {
    EXPECT_EQ(error.count(view, 0), 10.0);
    EXPECT_EQ(error.count(view, 1), 5.0);
    EXPECT_NEAR(error.sum_px(view, 0), 40.0, 0.01);
    EXPECT_NEAR(error.sum_px(view, 1), 50.0, 0.01);
    EXPECT_NEAR(error.MeanPx(view), 6.0, 1e-3);
    EXPECT_EQ(error.segments[view], 3.0);
  }
}

TEST(MeasureFit, IsZeroWithoutSegments) {
  const FitError error = FitOfRest(LeftAndRight(), {});
  EXPECT_EQ(error.sum_px.cols(), 0);
  EXPECT_EQ(error.MeanPx(), 0.0);
  EXPECT_EQ(error.MeanPx(1), 0.0);
  EXPECT_EQ(error.LastingM(0), 0.0);
}

// ---- Gains ----

// An error with ten measurements in each bin and view and the given means.
FitError ErrorOf(const Eigen::ArrayXXd& mean_px) {
  FitError error;
  error.count = Eigen::ArrayXXd::Constant(mean_px.rows(), mean_px.cols(), 10.0);
  error.sum_px = 10.0 * mean_px;
  error.segments = Eigen::ArrayXd::Constant(mean_px.rows(), 2.0);
  error.lasting_m = Eigen::ArrayXd::LinSpaced(
      mean_px.rows(), 0.04, 0.04 * static_cast<double>(mean_px.rows()));
  return error;
}

// The gain is the same in every bin, and so in every resample.
TEST(CompareFitsTest, ConstantGainHasAnExactInterval) {
  const Eigen::ArrayXXd before = Eigen::ArrayXXd::Constant(2, 20, 6.0);
  Eigen::ArrayXXd after = before;
  after.row(0) -= 1.0;
  const auto of = [&](int view) {
    return CompareFits(ErrorOf(before), ErrorOf(after), view);
  };
  const std::vector<std::pair<int, double>> gains = {
      {-1, 0.5}, {0, 1.0}, {1, 0.0}};
  for (const auto& [view, gain_px] : gains) {
    const FitGain gain = of(view);
    EXPECT_DOUBLE_EQ(gain.before_px, 6.0);
    EXPECT_DOUBLE_EQ(gain.after_px, 6.0 - gain_px);
    // Means of a few dozen terms have rounding errors of less than 1e-13.
    EXPECT_NEAR(gain.low_px, gain_px, 1e-12);
    EXPECT_NEAR(gain.high_px, gain_px, 1e-12);
    EXPECT_NEAR(gain.share(), gain_px / 6.0, 1e-12);
  }
  EXPECT_TRUE(of(-1).is_enough());
  EXPECT_FALSE(of(1).is_enough());
}

// The error falls by 2 px in half of the bins and rises by 2 px in the others.
TEST(CompareFitsTest, GainByChanceIsNotSignificant) {
  const Eigen::ArrayXXd before = Eigen::ArrayXXd::Constant(1, 20, 6.0);
  Eigen::ArrayXXd after = before;
  for (int bin = 0; bin < 20; ++bin) after(0, bin) += bin % 4 < 2 ? 2.0 : -2.0;
  const FitGain gain = CompareFits(ErrorOf(before), ErrorOf(after));
  EXPECT_FALSE(gain.certain());
  EXPECT_LT(gain.low_px, 0.0);
  EXPECT_GT(gain.high_px, 0.0);
}

TEST(CompareFitsTest, OneBinHasNoInterval) {
  const Eigen::ArrayXXd before = Eigen::ArrayXXd::Constant(2, 1, 6.0);
  const FitGain gain = CompareFits(ErrorOf(before), ErrorOf(0.5 * before));
  EXPECT_DOUBLE_EQ(gain.before_px, 6.0);
  EXPECT_DOUBLE_EQ(gain.after_px, 3.0);
  EXPECT_EQ(gain.low_px, 0.0);
  EXPECT_EQ(gain.high_px, 0.0);
  EXPECT_FALSE(gain.certain());
}

// Persistent errors are by view: 0.08 m over two segments in the second view.
TEST(CompareFitsTest, PersistentErrorsAreByView) {
  const FitError before = ErrorOf(Eigen::ArrayXXd::Constant(2, 20, 6.0));
  FitError after = before;
  after.lasting_m[1] = 0.02;
  const FitGain gain = CompareFits(before, after, 1);
  EXPECT_DOUBLE_EQ(gain.lasting_before_m, 0.04);
  EXPECT_DOUBLE_EQ(gain.lasting_after_m, 0.01);
  EXPECT_DOUBLE_EQ(gain.explained(), 0.75);
  EXPECT_EQ(CompareFits(before, after).lasting_before_m, 0.0);
  EXPECT_EQ(FitGain().explained(), 0.0);
  EXPECT_EQ(FitGain().share(), 0.0);
}

// The gain must be at least a twentieth of the error, and significant.
TEST(FitGainTest, IsEnoughDependsOnShareAndSignificance) {
  FitGain gain;
  gain.before_px = 10.0;
  gain.after_px = 9.4;
  gain.low_px = 0.01;
  EXPECT_TRUE(gain.is_enough());
  gain.low_px = -0.01;
  EXPECT_FALSE(gain.is_enough());
  gain.low_px = 0.01;
  gain.after_px = 9.6;
  EXPECT_TRUE(gain.certain());
  EXPECT_FALSE(gain.is_enough());
}

// ---- Cross-validation ----

// A camera is rotated by half a degree, 7 px. Joints fitted to all views leave
// at least a third of this as an error of its view. The rotation is estimated
// from one half of the data and reduces the error of the other half. Correct
// cameras have no significant gain.
TEST(CrossFitTest, GainsOnlyIfACameraIsWrong) {
  for (const bool turned : {false, true}) {
    testing::FaultyScene scene = testing::MakeFaultyScene({9, 4, 3, 8.0});
    if (turned) scene.cameras[2] = testing::Turned(scene.cameras[2], 0.5, 3);
    BundleOptions options;
    options.segments.max_segments = 400;
    const SceneSegments segments =
        MakeSegments(scene.cameras, scene.detections, testing::MatchesOf(scene),
                     options.segments);
    FreeParameters free;
    free.rotation = true;
    const CrossedGain gain = CrossFit(scene.cameras, segments, Halving::kTime,
                                      free, NoChanges(4), options);
    ASSERT_EQ(gain.views.size(), 4u);
    EXPECT_EQ(gain.all.is_enough(), turned);
    EXPECT_EQ(gain.views[2].is_enough(), turned);
    // Every measurement is in one of the halves.
    const FitError before =
        MeasureFit(scene.cameras, segments, NoChanges(4), options.segments);
    EXPECT_NEAR(gain.all.before_px, before.MeanPx(), 1e-9);
  }
}

}  // namespace
}  // namespace kinegraph
