#include "solvers/session/remembered_runs.h"

#include <gtest/gtest.h>

#include <string>

#include "core/io/configuration/config.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "solvers/noise/take_notes.h"
#include "solvers/session/session.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

struct Answer {
  std::vector<double> numbers;
  std::string learnt;
  int64_t solves = 0;
};

// A second of two people before three cameras, tracked by the batch.
Answer Track(Checkpoint* checkpoint) {
  SceneOptions scene_options;
  scene_options.people = 2;
  scene_options.duration_s = 1.0;
  scene_options.cameras.count = 3;
  const Scene scene = MakeScene(scene_options);
  ObservationTruth truth;
  const DetectionSequence detections = Observe(scene, NoiseOptions(), &truth);
  RunOptions options;
  options.estimators.mode = Mode::kGraph;
  options.estimators.output = OutputKind::kBatch;
  const auto ledger = std::make_shared<SolveLedger>();
  options.estimators.graph.ledger = ledger;
  RunRequest request;
  request.cameras = scene.cameras;
  MemorySource source(detections);
  Session session(
      options, request, detections.header,
      MakeRememberedEstimators(options.estimators, EffectiveConfigJson(options),
                               checkpoint),
      [&] { return std::make_unique<MemorySource>(detections); });
  Answer answer;
  TrackAll(&source, &session, [&](TrackFrame&& frame) {
    for (const PersonPose& person : frame.people) {
      for (const Joint3d& joint : person.joints) {
        for (int i = 0; i < 3; ++i) {
          answer.numbers.push_back(joint.position_m[i]);
        }
      }
    }
  });
  answer.learnt = ToJson(session.learnt_noise());
  answer.solves = ledger->Total().solves;
  return answer;
}

// Everything that the run says afterwards, not the poses alone.
TEST(RememberedRuns, AllThatASolveLeavesComesBack) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "checkpoint").string();
  Answer first;
  {
    Checkpoint checkpoint(path, "build", false, 0.0);
    first = Track(&checkpoint);
    EXPECT_EQ(checkpoint.found_count(), 0);
  }
  ASSERT_FALSE(first.numbers.empty());
  EXPECT_NE(first.learnt.find("wrist"), std::string::npos);
  EXPECT_GT(first.solves, 0);
  Checkpoint again(path, "build", true, 0.0);
  const Answer second = Track(&again);
  EXPECT_GT(again.found_count(), 0);
  EXPECT_EQ(second.numbers, first.numbers);
  EXPECT_EQ(second.learnt, first.learnt);
  EXPECT_EQ(second.solves, first.solves);
  // And what is learnt is what a run without a checkpoint learns.
  Checkpoint none;
  EXPECT_EQ(Track(&none).learnt, first.learnt);
}

}  // namespace
}  // namespace kinegraph::testing
