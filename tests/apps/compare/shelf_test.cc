// Freezing and replaying the real Shelf take.
#include "tests/support/shelf.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "apps/common/config_folder.h"
#include "core/tracking/replay.h"
#include "solvers/session/run.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

void ExpectSamePoses(const std::vector<TrackFrame>& run,
                     const std::vector<TrackFrame>& replayed) {
  ASSERT_EQ(run.size(), replayed.size());
  int64_t joints = 0;
  for (size_t f = 0; f < run.size(); ++f) {
    ASSERT_EQ(run[f].frame, replayed[f].frame);
    ASSERT_EQ(run[f].people.size(), replayed[f].people.size());
    for (size_t p = 0; p < run[f].people.size(); ++p) {
      const PersonPose& one = run[f].people[p];
      const PersonPose& other = replayed[f].people[p];
      EXPECT_EQ(one.id, other.id);
      for (size_t j = 0; j < one.joints.size(); ++j) {
        EXPECT_EQ(one.joints[j].status, other.joints[j].status);
        if (!one.joints[j].present()) continue;
        EXPECT_EQ(one.joints[j].position_m, other.joints[j].position_m);
        ++joints;
      }
    }
  }
  EXPECT_GT(joints, 10000);
}

// The run's own answer, the frozen run's and the replayed one, bit for bit.
void CheckReplay(const std::string& config, const std::string& set) {
  const testing::ShelfRecording recording =
      testing::LoadRawShelf(testing::FindData("")->string());
  const RunOptions options = ReadRunOptions(ProjectConfig(config), set, "");
  RunRequest request;
  request.cameras = recording.cameras;
  const TrackSequence tracked =
      TrackSequenceOf(options, request, recording.detections);
  const FrozenRun frozen =
      FreezeTracking(options, request, recording.detections);
  ExpectSamePoses(tracked.frames, frozen.tracks.frames);
  const Replay replay(frozen.scene.model, frozen.detections, frozen.matches,
                      options.tracker, FeedbackOf(options));
  const EstimatorPair estimators = MakeEstimators(options.estimators);
  const std::vector<ReplayedPerson> people = replay.Prepare(-1, 1);
  std::vector<ReplayOutcome> outcomes;
  for (const ReplayedPerson& person : people) {
    outcomes.push_back(RunEstimator(
        replay.scene(), person,
        estimators.output ? estimators.output : estimators.feedback));
  }
  ExpectSamePoses(tracked.frames,
                  AssembleReplay(replay.empty_frames(), people,
                                 std::move(outcomes), frozen.first_frame));
}

TEST(ShelfReplay, PaperModeWithWarmUpComesOutAgain) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  CheckReplay("paper/shelf.toml", "input.repeat_first_frame=3");
}

TEST(ShelfReplay, BatchOverBridgedGapsComesOutAgain) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  CheckReplay("graph/shelf.toml", "output.estimator=batch");
}

}  // namespace
}  // namespace kinegraph
