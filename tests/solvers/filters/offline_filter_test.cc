#include "solvers/filters/offline_filter.h"

#include <gtest/gtest.h>

#include <vector>

#include "solvers/factory.h"
#include "tests/support/rig.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

constexpr TimeNs kFrame = 40'000'000;  // 25 Hz

SceneModel Scene() {
  return {testing::RingOfCameras(3), Coco17(), 25.0, false};
}

// All joints at x = `x_m`, seen by three views.
EstimatorFrame At(int frame, double x_m) {
  EstimatorFrame in;
  in.frame = frame;
  in.time = frame * kFrame;
  in.has_initial = true;
  in.initial.resize(17);
  for (Joint3d& joint : in.initial) {
    joint.position_m = {x_m, 2.0 * x_m, 1.0};
    joint.status = JointStatus::kObserved;
  }
  in.triangulated.assign(17, 1);
  in.inlier_views.assign(17, 3);
  return in;
}

EstimatorFrame Failed(int frame) {
  EstimatorFrame in;
  in.frame = frame;
  in.time = frame * kFrame;
  in.inlier_views.assign(17, 0);
  return in;
}

SegmentFilter Raw() { return PointsAsTheyAre(false); }

JointPoints Points() { return {Scene(), PointKind::kDlt, false, {}, {}}; }

std::vector<FinalPose> RunRaw(const std::vector<EstimatorFrame>& frames,
                              double max_gap_s) {
  const auto estimator =
      MakeOfflineFilter(Scene(), {max_gap_s}, Points(), Raw());
  return testing::Run(estimator.get(), frames);
}

TEST(OfflineFilterTest, BridgesShortGapsAndMarksThem) {
  // Frames 2 and 3 failed; in frame 5 joint 3 was predicted, in frame 6
  // triangulated with an older view.
  std::vector<EstimatorFrame> frames = {At(0, 0.0), At(1, 1.0), Failed(2),
                                        Failed(3),  At(4, 4.0), At(5, 7.0),
                                        At(6, 9.0), At(7, 7.0)};
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

TEST(OfflineFilterTest, LongGapsPartTheSignal) {
  std::vector<EstimatorFrame> frames = {At(0, 0.0), At(1, 1.0), Failed(2),
                                        Failed(3),  Failed(4),  At(5, 5.0)};
  std::vector<size_t> lengths;
  const auto estimator =
      MakeOfflineFilter(Scene(), {0.12}, Points(),
                        [&](const JointSegment& segment) -> SegmentEstimate {
                          lengths.push_back(segment.times_s.size());
                          return {segment.positions_m, {}};
                        });
  const auto finals = testing::Run(estimator.get(), frames);
  EXPECT_EQ(lengths.size(), 2u * 17u);
  EXPECT_EQ(lengths[0], 2u);
  EXPECT_EQ(lengths[1], 1u);
  for (int k = 0; k < 6; ++k) {
    EXPECT_EQ(finals[k].person.joints[0].present(), k < 2 || k == 5) << k;
  }
}

TEST(OfflineFilterTest, NothingBeforeTheFirstOrAfterTheLastSample) {
  std::vector<EstimatorFrame> frames = {At(0, 0.0), At(1, 1.0), At(2, 2.0),
                                        Failed(3)};
  frames[0].inlier_views[5] = 0;
  frames[2].inlier_views[6] = 1;
  const auto finals = RunRaw(frames, 10.0);
  EXPECT_FALSE(finals[0].person.joints[5].present());
  EXPECT_TRUE(finals[0].person.joints[6].present());
  EXPECT_FALSE(finals[2].person.joints[6].present());
  EXPECT_TRUE(finals[2].person.joints[5].present());
  EXPECT_FALSE(finals[3].person.joints[0].present());
}

TEST(OfflineFilterTest, EveryStrategyMeetsTheInterface) {
  std::vector<EstimatorFrame> frames;
  for (int k = 0; k < 40; ++k) {
    frames.push_back(k % 9 == 4 ? Failed(k) : At(k, 0.02 * k));
  }
  for (size_t i = 0; i < OutputNames().size(); ++i) {
    SCOPED_TRACE(OutputNames()[i]);
    EstimatorOptions options;
    const auto kind = static_cast<OutputKind>(i);
    const auto estimator = MakeOutput(kind, options)(Scene());
    const auto finals = testing::Run(estimator.get(), frames);
    ASSERT_EQ(finals.size(), frames.size());
    for (size_t k = 0; k < finals.size(); ++k) {
      EXPECT_EQ(finals[k].frame, frames[k].frame);
      for (const Joint3d& joint : finals[k].person.joints) {
        EXPECT_TRUE(!joint.present() || joint.position_m.allFinite());
      }
    }
  }
}

}  // namespace
}  // namespace kinegraph
