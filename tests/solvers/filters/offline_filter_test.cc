#include "solvers/filters/offline_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "solvers/factory.h"
#include "tests/support/rig.h"
#include "tests/support/signals.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

using testing::FailedFrame;
using testing::FrameAt;

SceneModel Scene() {
  return {testing::RingOfCameras(3), Coco17(), 25.0, KeptMatches::kNone};
}

JointPoints Points() {
  return {Scene(), PointKind::kDlt, PointCovariances::kOff, {}, {}};
}

std::vector<FinalPose> RunRaw(const std::vector<EstimatorFrame>& frames,
                              double max_gap_s) {
  const auto estimator = MakeOfflineFilter(
      Scene(), {max_gap_s}, Points(), PointsAsTheyAre(PointCovariances::kOff));
  return testing::Run(estimator.get(), frames);
}

TEST(OfflineFilterTest, BridgesShortGapsAndMarksThem) {
  // Frames 2 and 3 failed; in frame 5 joint 3 was predicted, in frame 6
  // triangulated with an older view.
  std::vector<EstimatorFrame> frames = {
      FrameAt(0, 0.0), FrameAt(1, 1.0), FailedFrame(2),  FailedFrame(3),
      FrameAt(4, 4.0), FrameAt(5, 7.0), FrameAt(6, 9.0), FrameAt(7, 7.0)};
  frames[5].triangulated[3] = 0;
  frames[5].inlier_views[3] = 0;
  frames[6].inlier_views[3] = 1;
  const auto finals = RunRaw(frames, 0.12);
  ASSERT_EQ(finals.size(), 8u);
  const double other[] = {0.0, 1.0, 2.0, 3.0, 4.0, 7.0, 9.0, 7.0};
  const double third[] = {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0};
  for (int k = 0; k < 8; ++k) {
    EXPECT_EQ(finals[k].frame, k);
    for (int j = 0; j < 17; ++j) {
      const Joint3d& joint = finals[k].person.joints[j];
      const bool bridged = k == 2 || k == 3 || (j == 3 && (k == 5 || k == 6));
      EXPECT_EQ(joint.status,
                bridged ? JointStatus::kInferred : JointStatus::kObserved)
          << k << " " << j;
      EXPECT_NEAR(joint.position_m.x(), j == 3 ? third[k] : other[k], 1e-12);
      EXPECT_NEAR(joint.position_m.y(), 2.0 * joint.position_m.x(), 1e-12);
    }
  }
}

TEST(OfflineFilterTest, LongGapsSplitTheSignal) {
  std::vector<EstimatorFrame> frames = {FrameAt(0, 0.0), FrameAt(1, 1.0),
                                        FailedFrame(2),  FailedFrame(3),
                                        FailedFrame(4),  FrameAt(5, 5.0)};
  // Consecutive frames do not form a gap, however small max_gap is.
  for (const double max_gap_s : {0.12, 0.01, 0.0}) {
    std::vector<size_t> lengths;
    const auto estimator =
        MakeOfflineFilter(Scene(), {max_gap_s}, Points(),
                          [&](const JointSegment& segment) -> SegmentEstimate {
                            lengths.push_back(segment.times_s.size());
                            return {segment.positions_m, {}};
                          });
    const auto finals = testing::Run(estimator.get(), frames);
    ASSERT_EQ(lengths.size(), 2u * 17u) << max_gap_s;
    EXPECT_EQ(lengths[0], 2u);
    EXPECT_EQ(lengths[1], 1u);
    for (int k = 0; k < 6; ++k) {
      EXPECT_EQ(finals[k].person.joints[0].present(), k < 2 || k == 5) << k;
    }
  }
}

TEST(OfflineFilterTest, OneCutoffForTheBodyIsTheMedian) {
  // Five frames of moving joints and a separate single frame. The filter
  // chooses 2 Hz for the five frames and 9 Hz for the single one; the median
  // weights them by their frames.
  std::vector<EstimatorFrame> frames;
  for (int k = 0; k < 5; ++k) frames.push_back(FrameAt(k, k));
  for (int k = 5; k < 9; ++k) frames.push_back(FailedFrame(k));
  frames.push_back(FrameAt(9, 9.0));
  for (const CutoffPer per : {CutoffPer::kJoint, CutoffPer::kBody}) {
    OfflineFilterOptions options;
    options.max_gap_s = 0.12;
    options.cutoff_per = per;
    std::vector<std::optional<double>> given;
    const auto estimator =
        MakeOfflineFilter(Scene(), options, Points(),
                          [&](const JointSegment& segment) -> SegmentEstimate {
                            given.push_back(segment.cutoff_hz);
                            return {segment.positions_m,
                                    {},
                                    {segment.times_s.size() > 1 ? 2.0 : 9.0}};
                          });
    testing::Run(estimator.get(), frames);
    const bool body = per == CutoffPer::kBody;
    ASSERT_EQ(given.size(), (body ? 2u : 1u) * 2u * 17u);
    for (size_t i = 0; i < given.size(); ++i) {
      if (i < 2 * 17) {
        EXPECT_EQ(given[i], std::nullopt);
      } else {
        EXPECT_EQ(given[i], 2.0);
      }
    }
  }
}

TEST(OfflineFilterTest, NothingBeforeTheFirstOrAfterTheLastSample) {
  std::vector<EstimatorFrame> frames = {FrameAt(0, 0.0), FrameAt(1, 1.0),
                                        FrameAt(2, 2.0), FailedFrame(3)};
  frames[0].inlier_views[5] = 0;
  frames[2].inlier_views[6] = 1;
  const auto finals = RunRaw(frames, 10.0);
  EXPECT_FALSE(finals[0].person.joints[5].present());
  EXPECT_TRUE(finals[0].person.joints[6].present());
  EXPECT_FALSE(finals[2].person.joints[6].present());
  EXPECT_TRUE(finals[2].person.joints[5].present());
  EXPECT_FALSE(finals[3].person.joints[0].present());
}

// A walk of two seconds in four views, with missing joints, so that some frames
// have a joint in fewer than two views.
class EveryStrategyTest : public ::testing::TestWithParam<int> {
 protected:
  OutputKind kind() const { return static_cast<OutputKind>(GetParam()); }
  // Whether the strategy filters triangulated points. Window, batch and
  // Gaussian bridge gaps and report covariances by different rules.
  bool IsFilter() const {
    return kind() != OutputKind::kWindow && kind() != OutputKind::kBatch &&
           kind() != OutputKind::kGaussian;
  }

  std::vector<FinalPose> Estimate(
      const std::vector<EstimatorFrame>& frames) const {
    const auto estimator = MakeOutput(kind(), options_)(scene_);
    return testing::Run(estimator.get(), frames);
  }

  testing::SimulatedRecording Walk(double outliers) const {
    testing::SimulatedNoise noise;
    noise.missing = 0.4;
    noise.outliers = outliers;
    testing::SimulatedRecording recording = testing::Simulate(
        scene_, options_.graph, testing::WalkingMotion(scene_, 50), noise, 5);
    for (EstimatorFrame& frame : recording.frames) {
      for (const Joint3d& joint : frame.initial) {
        frame.triangulated.push_back(joint.present());
        frame.inlier_views.push_back(joint.present() ? 2 : 0);
      }
    }
    return recording;
  }

  const SceneModel scene_{testing::RingOfCameras(4, 5.0, 1000.0),
                          testing::SmallSkeleton(), 25.0,
                          KeptMatches::kWeights};
  EstimatorOptions options_;
};

TEST_P(EveryStrategyTest, MarksJointsObservedWhereTriangulated) {
  const testing::SimulatedRecording recording = Walk(0.0);
  const auto finals = Estimate(recording.frames);
  ASSERT_EQ(finals.size(), recording.frames.size());
  const bool gives_covariances = kind() == OutputKind::kKalman ||
                                 kind() == OutputKind::kRts ||
                                 kind() == OutputKind::kStudentTRts ||
                                 kind() == OutputKind::kRobustTriangulation;
  int bridged = 0;
  for (size_t k = 0; k < finals.size(); ++k) {
    const PersonPose& person = finals[k].person;
    EXPECT_EQ(finals[k].frame, recording.frames[k].frame);
    EXPECT_EQ(person.matches.size(), recording.frames[k].views.size());
    for (size_t j = 0; j < person.joints.size(); ++j) {
      const Joint3d& joint = person.joints[j];
      if (!joint.present()) continue;
      EXPECT_TRUE(joint.position_m.allFinite());
      bridged += joint.status == JointStatus::kInferred ? 1 : 0;
      if (!IsFilter()) continue;
      // A joint is observed exactly where the initial pose contains it, which
      // requires two or more rays.
      if (kind() != OutputKind::kRobustTriangulation) {
        EXPECT_EQ(joint.status == JointStatus::kObserved,
                  recording.frames[k].initial[j].present());
      }
      const bool has_covariance =
          j < person.covariances.size() && person.covariances[j].has_value();
      const bool expected =
          gives_covariances && (joint.status == JointStatus::kObserved ||
                                kind() != OutputKind::kRobustTriangulation);
      EXPECT_EQ(has_covariance, expected) << k << " " << j;
      if (has_covariance) {
        EXPECT_GT(person.covariances[j]->ldlt().vectorD().minCoeff(), 0.0);
      }
    }
  }
  EXPECT_TRUE(bridged > 5 || !IsFilter());
}

TEST_P(EveryStrategyTest, OnlyCausalStrategiesIgnoreLaterFrames) {
  testing::SimulatedRecording recording = Walk(0.0);
  const auto whole = Estimate(recording.frames);
  recording.frames.resize(30);
  const auto part = Estimate(recording.frames);
  bool same = true;
  for (size_t k = 0; k < part.size(); ++k) {
    for (size_t j = 0; j < part[k].person.joints.size(); ++j) {
      const Joint3d& joint = part[k].person.joints[j];
      if (joint.status != JointStatus::kObserved) continue;
      same = same && joint.position_m == whole[k].person.joints[j].position_m;
    }
  }
  EXPECT_EQ(same, IsCausal(kind(), options_));
}

TEST_P(EveryStrategyTest, IsNearTheTruth) {
  // Median and Gaussian flatten the bounce of 3 cm; causal filters lag by a
  // few hundredths of a second at 1 m/s.
  const testing::SimulatedRecording recording = Walk(0.0);
  EXPECT_LT(
      testing::RootMeanSquare(recording.truth, Estimate(recording.frames)),
      0.08);
}

std::string NameOf(const ::testing::TestParamInfo<int>& info) {
  return OutputNames()[info.param];
}

INSTANTIATE_TEST_SUITE_P(
    All, EveryStrategyTest,
    ::testing::Range(0, static_cast<int>(OutputNames().size())), NameOf);

TEST(RobustPointsTest, ResistOutliersThatSpoilTheInitialPose) {
  // Five views, one observation in ten with an error of 30 to 200 px, and an
  // initial pose that is the least-squares point of all rays.
  const SceneModel scene{testing::RingOfCameras(5, 5.0, 1000.0),
                         testing::SmallSkeleton(), 25.0, KeptMatches::kWeights};
  EstimatorOptions options;
  const auto rms = [&](double outliers, OutputKind kind) {
    testing::SimulatedNoise noise;
    noise.outliers = outliers;
    const testing::SimulatedRecording recording = testing::Simulate(
        scene, options.graph, testing::WalkingMotion(scene, 200), noise, 9);
    const auto estimator = MakeOutput(kind, options)(scene);
    return testing::RootMeanSquare(
        recording.truth, testing::Run(estimator.get(), recording.frames));
  };
  const double clean_m = rms(0.0, OutputKind::kRobustTriangulation);
  // One joint in twelve has two or more outliers among its five views, and
  // outliers of 30 px, six sigmas, still have some weight.
  EXPECT_LT(rms(0.1, OutputKind::kRobustTriangulation), 2.5 * clean_m);
  EXPECT_GT(rms(0.1, OutputKind::kRawDlt), 3.0 * clean_m);
  // Filters on these points keep the gain.
  options.filters.points = PointKind::kRobust;
  EXPECT_LT(rms(0.1, OutputKind::kRts), clean_m);
}

TEST(OfflineFilterTest, RejectsNonUniformTimeAndInvalidOptions) {
  std::vector<EstimatorFrame> frames = {FrameAt(0, 0.0), FrameAt(1, 1.0),
                                        FrameAt(3, 2.0)};
  EstimatorOptions options;
  for (const OutputKind kind :
       {OutputKind::kButterworth, OutputKind::kCriticallyDamped,
        OutputKind::kSavitzkyGolay}) {
    const auto estimator = MakeOutput(kind, options)(Scene());
    for (const EstimatorFrame& frame : frames) estimator->Add(frame);
    EXPECT_THROW(estimator->Finish(), InputError);
  }
  // The other filters accept non-uniform time, and a gap that splits the signal
  // does not make it non-uniform.
  for (const OutputKind kind :
       {OutputKind::kRawDlt, OutputKind::kCentredGaussian,
        OutputKind::kHampelMedian, OutputKind::kOneEuro,
        OutputKind::kSmoothingSpline, OutputKind::kQuinticSpline,
        OutputKind::kWhittaker, OutputKind::kLoess, OutputKind::kTrend}) {
    const auto estimator = MakeOutput(kind, options)(Scene());
    EXPECT_EQ(testing::Run(estimator.get(), frames).size(), 3u);
  }
  options.filters.segments.max_gap_s = 0.05;
  const auto estimator = MakeOutput(OutputKind::kButterworth, options)(Scene());
  EXPECT_EQ(testing::Run(estimator.get(), frames).size(), 3u);
  // A cut-off at half the frame rate is rejected when the scene is known, a
  // negative cut-off at once.
  options.filters.butterworth.cutoff_hz = 12.5;
  EXPECT_THROW(MakeOutput(OutputKind::kButterworth, options)(Scene()),
               OptionError);
  options.filters.butterworth.cutoff_hz = -1.0;
  EXPECT_THROW(MakeOutput(OutputKind::kRawDlt, options), OptionError);
}

}  // namespace
}  // namespace kinegraph
