#include "solvers/session/remembered_runs.h"

#include <gtest/gtest.h>

#include <string>

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

// Three seconds and a half of two people before three cameras, tracked by the
// batch in chunks of a second.
Answer Track(Checkpoint* checkpoint, ViewBiasUse view_bias) {
  SceneOptions scene_options;
  scene_options.people = 2;
  scene_options.motion.visitors = 0.0;  // there all the time
  scene_options.duration_s = 3.5;
  scene_options.cameras.count = 3;
  const Scene scene = MakeScene(scene_options);
  ObservationTruth truth;
  const DetectionSequence detections = Observe(scene, NoiseOptions(), &truth);
  RunOptions options;
  options.estimators.mode = Mode::kGraph;
  options.estimators.output = OutputKind::kBatch;
  const auto ledger = std::make_shared<SolveLedger>();
  options.estimators.graph.ledger = ledger;
  options.estimators.graph.chunk_s = 1.0;
  options.estimators.graph.bones = true;
  options.estimators.graph.view_bias = view_bias;
  options.estimators.graph.pieces = checkpoint;
  RunRequest request;
  request.cameras = scene.cameras;
  MemorySource source(detections);
  Session session(options, request, detections.header,
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

class RememberedRuns : public ::testing::TestWithParam<ViewBiasUse> {};

// Everything that the run says afterwards, not the poses alone.
TEST_P(RememberedRuns, AllThatASolveLeavesComesBack) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "checkpoint").string();
  Answer first;
  {
    Checkpoint checkpoint(path, "build", false, 0.0);
    first = Track(&checkpoint, GetParam());
  }
  ASSERT_FALSE(first.numbers.empty());
  EXPECT_NE(first.learnt.find("wrist"), std::string::npos);
  EXPECT_GT(first.solves, 0);
  Checkpoint again(path, "build", true, 0.0);
  const Answer second = Track(&again, GetParam());
  // Two people in three chunks: joints, all together, covariances twice.
  EXPECT_GE(again.found_count(), 2 * 3 * 4);
  EXPECT_EQ(second.numbers, first.numbers);
  EXPECT_EQ(second.learnt, first.learnt);
  EXPECT_EQ(second.solves, first.solves);
  const Answer none = Track(nullptr, GetParam());
  EXPECT_EQ(none.numbers, first.numbers);
  EXPECT_EQ(none.learnt, first.learnt);
  EXPECT_EQ(none.solves, first.solves);
}

INSTANTIATE_TEST_SUITE_P(ViewBias, RememberedRuns,
                         ::testing::Values(ViewBiasUse::kOff,
                                           ViewBiasUse::kOn));

}  // namespace
}  // namespace kinegraph::testing
