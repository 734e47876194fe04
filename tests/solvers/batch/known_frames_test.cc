// Reuse of solved frames by a second pass.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "solvers/batch/batch_estimator.h"
#include "solvers/batch/recording_solver.h"
#include "solvers/noise/recording_notes.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

class KnownFramesTest : public ::testing::Test {
 protected:
  static constexpr size_t kFrames = 400;

  void SetUp() override {
    scene_ = testing::SmallScene(testing::RingOfCameras(5, 5.0, 1000.0), 25.0);
    options_.solver = GraphSolver::kBlockTridiagonal;
    options_.bones = true;
    options_.chunk_s = 4.0;
    testing::SimulatedNoise noise;
    noise.correlation_time_s = 0.1;
    noise.missing = 0.1;
    noise.outliers = 0.05;
    recording_ = testing::Simulate(
        scene_, options_, testing::WalkingMotion(scene_, kFrames), noise, 67);
  }

  struct Run {
    std::vector<FinalPose> finals;
    SolveCounts counts;
  };
  Run Pass(const std::vector<EstimatorFrame>& frames,
           const std::shared_ptr<RecordingNotes>& notes) const {
    GraphOptions options = options_;
    options.ledger = std::make_shared<SolveLedger>();
    const auto estimator = MakeBatchEstimator(scene_, options, notes);
    Run run;
    run.finals = testing::Run(estimator.get(), frames);
    run.counts = options.ledger->Total();
    return run;
  }

  // The second of two passes. The first receives the recording without its last
  // `missing` frames, the second receives `second`.
  Run SecondPass(const std::vector<EstimatorFrame>& second,
                 size_t missing = 0) const {
    const auto notes = std::make_shared<RecordingNotes>(options_);
    notes->ExpectAnotherPass();
    Pass({recording_.frames.begin(), recording_.frames.end() - missing}, notes);
    notes->BeginPass();
    return Pass(second, notes);
  }

  static double Apart(const std::vector<FinalPose>& a,
                      const std::vector<FinalPose>& b, size_t k) {
    double farthest_m = 0.0;
    for (size_t j = 0; j < a[k].person.joints.size(); ++j) {
      farthest_m = std::max(farthest_m, testing::Apart(a[k].person.joints[j],
                                                       b[k].person.joints[j]));
    }
    return farthest_m;
  }

  SceneModel scene_;
  GraphOptions options_;
  testing::SimulatedRecording recording_;
};

TEST_F(KnownFramesTest, UnchangedMatchesAreNotSolvedAgain) {
  const Run alone = Pass(recording_.frames, nullptr);
  EXPECT_GT(alone.counts.solves, 0);
  // The order of views, which in the tracker is that of their first match, does
  // not matter.
  std::vector<EstimatorFrame> reordered = recording_.frames;
  for (EstimatorFrame& frame : reordered) {
    std::reverse(frame.views.begin(), frame.views.end());
  }
  for (const auto& frames : {recording_.frames, reordered}) {
    const Run second = SecondPass(frames);
    EXPECT_EQ(second.counts.solves, 0);
    ASSERT_EQ(second.finals.size(), kFrames);
    for (size_t k = 0; k < kFrames; ++k) {
      EXPECT_EQ(Apart(alone.finals, second.finals, k), 0.0) << k;
      // The last pass computes the covariances with bones.
      EXPECT_EQ(alone.finals[k].person.covariances,
                second.finals[k].person.covariances);
    }
  }
}

TEST_F(KnownFramesTest, FramesNearAChangedMatchAreSolvedAgain) {
  std::vector<EstimatorFrame> changed = recording_.frames;
  changed[200].views.pop_back();
  const Run alone = Pass(changed, nullptr);
  const Run second = SecondPass(changed);
  EXPECT_GT(second.counts.solves, 0);
  EXPECT_LT(second.counts.sweep_iterations, alone.counts.sweep_iterations);
  // Noise and bones learnt from the first pass differ by one of 2000 views,
  // which moves a joint by less than a hundredth of the error of a frame's
  // triangulation: 24 mm per view (sigma_px: 6 px at 4 m with a focal length of
  // 1000 px, the same length at any depth), 15 mm per horizontal axis from five
  // views.
  for (size_t k = 0; k < kFrames; ++k) {
    EXPECT_LT(Apart(alone.finals, second.finals, k), 1.5e-4) << k;
  }
  // The frame with the missing view was not reused.
  EXPECT_GT(Apart(Pass(recording_.frames, nullptr).finals, second.finals, 200),
            1e-4);
}

TEST_F(KnownFramesTest, ManyChangedFramesAreSolvedFromScratch) {
  std::vector<EstimatorFrame> changed = recording_.frames;
  // Two of 400 frames: more than 1/400, up to which frames are reused.
  for (size_t k = 0; k < kFrames; k += 200) changed[k].views.pop_back();
  const Run alone = Pass(changed, nullptr);
  const Run second = SecondPass(changed);
  EXPECT_EQ(second.counts.sweep_iterations, alone.counts.sweep_iterations);
  for (size_t k = 0; k < kFrames; ++k) {
    EXPECT_EQ(Apart(alone.finals, second.finals, k), 0.0) << k;
  }
}

TEST_F(KnownFramesTest, AppendedFrameIsSolvedWithItsNeighbours) {
  const Run second = SecondPass(recording_.frames, 1);
  const Run alone = Pass(recording_.frames, nullptr);
  ASSERT_EQ(second.finals.size(), kFrames);
  EXPECT_LT(second.counts.sweep_iterations, alone.counts.sweep_iterations);
  // Five additional matches, each of which moves a joint by less than 0.15 mm
  // (FramesNearAChangedMatchAreSolvedAgain).
  for (size_t k = 0; k < kFrames; ++k) {
    EXPECT_LT(Apart(alone.finals, second.finals, k), 7.5e-4) << k;
  }
}

}  // namespace
}  // namespace kinegraph
