#include "core/tracking/replay.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "core/tracking/tracker.h"
#include "solvers/factory.h"

namespace kinegraph {
namespace {

// A crowd with gaps, outliers, false people and people who come and go, so that
// tracks are born, lost, bridged and dropped before they are confirmed; with
// the output and the matches of a tracker.
struct FrozenRecording {
  SceneModel scene;
  DetectionSequence detections;
  TrackerOptions options;
  EstimatorPair estimators;
  std::vector<TrackFrame> frames;
  FrozenMatches matches;

  const EstimatorFactory& written() const {
    return estimators.output ? estimators.output : estimators.feedback;
  }
  Replay replay() const {
    return Replay(scene, detections, matches, options, estimators.feedback);
  }
};

// The detector runs on every `detect_every`-th frame.
FrozenRecording Freeze(const EstimatorOptions& estimators,
                       const TrackerOptions& tracking = {},
                       int detect_every = 1) {
  SceneOptions options;
  options.seed = 5;
  options.people = 5;
  options.duration_s = 6.0;
  options.motion.area_radius_m = 2.2;
  options.motion.visitors = 0.6;
  options.cameras.count = 4;
  options.cameras.distortion = {-0.1, 0.02, 0.0, 0.0, 0.0};
  NoiseOptions noise;
  noise.seed = 5;
  noise.missed_rate = 0.15;
  noise.joints.missing_rate = 0.15;
  noise.joints.outlier_rate = 0.08;
  noise.false_people = 0.5;
  const Scene scene = MakeScene(options);
  FrozenRecording frozen = {{scene.cameras, scene.skeleton, scene.frame_rate_hz,
                             KeptMatches::kWeights},
                            Observe(scene, noise, nullptr),
                            tracking,
                            MakeEstimators(estimators),
                            {},
                            {}};
  for (size_t f = 0; f < frozen.detections.frames.size(); ++f) {
    if (f % static_cast<size_t>(detect_every) == 0) continue;
    for (ViewDetections& view : frozen.detections.frames[f].views) {
      view.detections.clear();
    }
  }
  MatchFreezer freezer;
  EstimatorPair wrapped = frozen.estimators;
  (wrapped.output ? wrapped.output : wrapped.feedback) =
      freezer.Wrap(frozen.written());
  Tracker tracker(frozen.scene, frozen.detections.header.skeleton, tracking,
                  wrapped.feedback, wrapped.output);
  for (const DetectionFrame& frame : frozen.detections.frames) {
    tracker.Process(frame, &frozen.frames);
  }
  tracker.Finish(&frozen.frames);
  frozen.matches = freezer.Matches(frozen.frames);
  return frozen;
}

std::vector<TrackFrame> ReplayAll(const Replay& replay, int without_view,
                                  const EstimatorFactory& estimator,
                                  int threads = 1) {
  const std::vector<ReplayedPerson> people =
      replay.Prepare(without_view, threads);
  std::vector<ReplayOutcome> outcomes;
  for (const ReplayedPerson& person : people) {
    outcomes.push_back(RunEstimator(replay.scene(), person, estimator));
  }
  return AssembleReplay(replay.empty_frames(), people, std::move(outcomes));
}

// Expects two results to be bit-identical.
void ExpectEqual(const std::vector<TrackFrame>& a,
                 const std::vector<TrackFrame>& b) {
  ASSERT_EQ(a.size(), b.size());
  int64_t joints = 0;
  for (size_t f = 0; f < a.size(); ++f) {
    EXPECT_EQ(a[f].frame, b[f].frame);
    ASSERT_EQ(a[f].people.size(), b[f].people.size()) << "frame " << a[f].frame;
    for (size_t p = 0; p < a[f].people.size(); ++p) {
      const PersonPose& one = a[f].people[p];
      const PersonPose& other = b[f].people[p];
      EXPECT_EQ(one.id, other.id);
      EXPECT_EQ(one.inlier_views, other.inlier_views);
      EXPECT_EQ(one.score, other.score);
      EXPECT_EQ(one.matches.size(), other.matches.size());
      EXPECT_EQ(one.covariances == other.covariances, true);
      for (size_t j = 0; j < one.joints.size(); ++j) {
        EXPECT_EQ(one.joints[j].status, other.joints[j].status);
        if (!one.joints[j].present()) continue;
        EXPECT_EQ(one.joints[j].position_m, other.joints[j].position_m)
            << "frame " << a[f].frame << ", joint " << j;
        ++joints;
      }
    }
  }
  EXPECT_GT(joints, 1000);  // the recordings are not empty
}

EstimatorOptions Paper() {
  EstimatorOptions options;
  options.mode = Mode::kPaper;
  return options;
}

EstimatorOptions Graph(OutputKind output) {
  EstimatorOptions options;
  options.mode = Mode::kGraph;
  options.output = output;
  return options;
}

TEST(Replay, ReproducesTheRun) {
  struct Case {
    const char* name;
    EstimatorOptions estimators;
    double max_gap_frames;
    bool backfill;
    NewestRule newest = NewestRule::kPose;
  };
  EstimatorOptions window_serves_both = Graph(OutputKind::kWindow);
  window_serves_both.feedback = FeedbackKind::kWindow;
  const Case cases[] = {
      {"paper", Paper(), TrackerOptions().life.max_gap_frames, false},
      {"window", Graph(OutputKind::kWindow), 10.0, true},
      {"window serves association", window_serves_both, 10.0, false},
      {"newest joints", Paper(), TrackerOptions().life.max_gap_frames, false,
       NewestRule::kJoint}};
  for (const Case& test : cases) {
    SCOPED_TRACE(test.name);
    TrackerOptions options;
    options.life.max_gap_frames = test.max_gap_frames;
    options.life.backfill = test.backfill;
    options.reconstruction.newest = test.newest;
    if (test.newest == NewestRule::kJoint) {
      // The default would remove nearly all weight of older detections.
      options.reconstruction.lambda_t_per_frame = 0.1;
    }
    const FrozenRecording frozen = Freeze(test.estimators, options);
    // With three threads, because the result must not depend on their number.
    ExpectEqual(frozen.frames, ReplayAll(frozen.replay(), -1, frozen.written(),
                                         /*threads=*/3));
  }
}

TEST(Replay, ReproducesRunWithDetectionsOnEveryThirdFrame) {
  TrackerOptions options;
  options.life.in_seconds = true;
  const FrozenRecording frozen =
      Freeze(Graph(OutputKind::kWindow), options, /*detect_every=*/3);
  ExpectEqual(frozen.frames, ReplayAll(frozen.replay(), -1, frozen.written()));
}

// A replay without a camera must not depend on that camera's detections.
TEST(Replay, IgnoresTheCameraLeftOut) {
  FrozenRecording frozen = Freeze(Paper());
  const auto run = [&] {
    return ReplayAll(frozen.replay(), 2,
                     MakeEstimators(Graph(OutputKind::kBatch)).output);
  };
  const std::vector<TrackFrame> before = run();
  for (DetectionFrame& frame : frozen.detections.frames) {
    for (Detection& detection : frame.views[2].detections) {
      for (Keypoint& joint : detection.joints) joint.px.x() += 300.0;
    }
  }
  ExpectEqual(before, run());
  for (const TrackFrame& frame : before) {
    for (const PersonPose& person : frame.people) {
      for (const ViewMatch& match : person.matches) {
        EXPECT_NE(match.view_idx, 2);
      }
    }
  }
}

TEST(Replay, ReportsTheDelayOfAnEstimator) {
  EstimatorOptions window = Graph(OutputKind::kWindow);
  window.graph.lag_s = 0.2;  // five frames of 25 Hz
  const FrozenRecording frozen = Freeze(window);
  const Replay replay = frozen.replay();
  for (const ReplayedPerson& person : replay.Prepare(-1, 1)) {
    if (person.frames.size() < 20) continue;
    const auto delay = [&](const EstimatorFactory& estimator) {
      return RunEstimator(replay.scene(), person, estimator).delay;
    };
    EXPECT_EQ(delay(frozen.estimators.feedback).value(), 0);
    EXPECT_NEAR(ToSeconds(delay(frozen.estimators.output).value()), 0.2, 1e-9);
    EXPECT_FALSE(
        delay(MakeEstimators(Graph(OutputKind::kBatch)).output).has_value());
  }
}

TEST(Replay, RefusesMatchesOfAnotherRecording) {
  FrozenRecording frozen = Freeze(Paper());
  for (FrozenPerson& person : frozen.matches.people) {
    for (FrozenFrame& frame : person.frames) frame.frame += 100000;
  }
  EXPECT_THROW(frozen.replay(), InputError);
}

}  // namespace
}  // namespace kinegraph
