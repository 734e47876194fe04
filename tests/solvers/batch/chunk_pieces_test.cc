#include "solvers/batch/chunk_pieces.h"

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "solvers/batch/take_solver.h"
#include "solvers/graph/assembler.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

class MapStore final : public PieceStore {
 public:
  std::optional<std::string> Find(const std::string& key) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto at = pieces.find(key);
    if (at == pieces.end()) return std::nullopt;
    ++found;
    return at->second;
  }
  void Add(const std::string& key, std::string value) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    pieces[key] = std::move(value);
  }

  std::map<std::string, std::string> pieces;
  int found = 0;

 private:
  std::mutex mutex_;
};

// Ten seconds of an arm.
class ChunkPiecesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    scene_ = testing::SmallScene(testing::RingOfCameras(4, 5.0, 1000.0), 25.0);
    testing::SimulatedNoise noise;
    noise.missing = 0.1;
    noise.outliers = 0.05;
    Random random(62);
    testing::SimulatedTake take =
        testing::Simulate(scene_, options_, testing::WalkingMotion(scene_, 250),
                          noise, Eigen::Vector3d::Zero(), &random);
    take.Connect();
    Assembler assembler(scene_, options_);
    problem_ = assembler.EmptyProblem();
    for (const EstimatorFrame& frame : take.frames) {
      assembler.Append(frame, &problem_);
    }
    problem_.bones.push_back({0, 1, 0.3, 0.01, LossKind::kNone, 3.0});
  }

  struct Answer {
    std::vector<PersonStates> states;  // alone, then together
    std::vector<std::vector<Eigen::Matrix3d>> covariances;
    SolveCounts counts;
  };
  Answer Solve(PieceStore* pieces, int threads) const {
    GraphOptions options = options_;
    options.chunk_s = 2.5;
    options.pieces = pieces;
    options.ledger = std::make_shared<SolveLedger>();
    PersonProblem alone = problem_;
    alone.bones.clear();
    PersonTake take = PackTake(alone);
    Answer answer;
    ParallelFor(threads, 1, [&](int) {
      TakeSolver solver(options);
      solver.SolveJointsWithRivals(solver.schedule(), &take);
      answer.states.push_back(StatesOf(UnpackTake(take)));
      take.graph.bones = problem_.bones;
      solver.SolveTogether(&take);
      answer.states.push_back(StatesOf(UnpackTake(take)));
      answer.covariances = solver.Covariances(take);
      solver.HandInCounts(0, 249);
    });
    answer.counts = options.ledger->Total();
    return answer;
  }

  static void ExpectSame(const Answer& a, const Answer& b) {
    EXPECT_EQ(a.states, b.states);
    EXPECT_EQ(a.covariances, b.covariances);
    for (const auto count : kSolveCounts) {
      EXPECT_EQ(a.counts.*count, b.counts.*count);
    }
  }

  SceneModel scene_;
  GraphOptions options_;
  PersonProblem problem_;
};

TEST_F(ChunkPiecesTest, WhatIsKeptIsNotComputedAgainAndHasTheSameBits) {
  const Answer expected = Solve(nullptr, 1);
  ASSERT_GT(expected.counts.solves, 0);
  ASSERT_NE(expected.states[0], expected.states[1]);
  MapStore store;
  ExpectSame(Solve(&store, 2), expected);
  EXPECT_EQ(store.found, 0);
  // Three chunks, three steps.
  ASSERT_EQ(store.pieces.size(), 9u);
  ExpectSame(Solve(&store, 1), expected);
  EXPECT_EQ(store.found, 9);
  // A run that was ended has some of them.
  int index = 0;
  for (auto at = store.pieces.begin(); at != store.pieces.end();) {
    at = ++index % 2 == 0 ? store.pieces.erase(at) : std::next(at);
  }
  store.found = 0;
  ExpectSame(Solve(&store, 2), expected);
  EXPECT_EQ(store.found, 5);
  EXPECT_EQ(store.pieces.size(), 9u);
}

TEST_F(ChunkPiecesTest, TheKeySeesAllThatTheResultDependsOn) {
  const Chunk chunk = {0, 100, 10, 90};
  PersonProblem problem = CutOut(PackTake(problem_), chunk);
  problem.bones = problem_.bones;
  std::set<std::string> keys;
  const auto key = [&](const std::string& step, const GraphOptions& options) {
    return ChunkKey(step, PersonSolver(options), chunk, problem);
  };
  keys.insert(key("a", options_));
  EXPECT_EQ(key("a", options_).size(), 32u);  // as Fingerprint::Hex
  size_t expected = 1;
  const auto expect_another = [&](const std::string& what,
                                  const std::string& other) {
    keys.insert(other);
    EXPECT_EQ(keys.size(), ++expected) << what;
  };
  EXPECT_EQ(key("a", options_), *keys.begin());
  expect_another("step", key("b", options_));

  const std::map<std::string, std::function<void(GraphOptions*)>> options = {
      {"solver", [](auto* o) { o->solver = GraphSolver::kSweeps; }},
      {"rivals", [](auto* o) { o->rival_starts = false; }},
      {"inlier weight", [](auto* o) { o->inlier_weight *= 2.0; }},
      {"loss", [](auto* o) { o->loss_scale *= 2.0; }},
      {"iterations", [](auto* o) { o->max_iterations = 7; }},
      {"tolerance", [](auto* o) { o->step_tolerance_m *= 2.0; }},
      {"swing", [](auto* o) { o->bone_swing = !o->bone_swing; }}};
  for (const auto& [what, change] : options) {
    GraphOptions changed = options_;
    change(&changed);
    expect_another(what, key("a", changed));
  }

  expect_another("own frames", ChunkKey("a", PersonSolver(options_),
                                        {0, 100, 10, 91}, problem));

  CameraParameters moved = scene_.cameras[0].parameters();
  moved.t.x() += 1e-9;
  const Camera camera(moved);
  const std::map<std::string, std::function<void(PersonProblem*)>> changes = {
      {"time", [](auto* p) { ++p->times[3]; }},
      {"motion", [](auto* p) { p->joints[1].process_noise[5] *= 1.5; }},
      {"prior", [](auto* p) { p->joints[1].prior.x0[2] += 1e-9; }},
      {"prior's information",
       [](auto* p) { p->joints[1].prior.A(0, 1) = 1.0; }},
      {"start", [](auto* p) { p->joints[2].states[9][4] += 1e-9; }},
      {"pixel", [](auto* p) { p->joints[0].measurements[4].px.x() += 1e-9; }},
      {"bias",
       [](auto* p) { p->joints[0].measurements[4].bias_px.y() = 1.0F; }},
      {"sigma", [](auto* p) { p->joints[0].measurements[4].sigma_px = 1.7; }},
      {"information",
       [](auto* p) { p->joints[0].measurements[4].information = 0.1; }},
      {"offset", [](auto* p) { p->joints[0].measurements[4].offset_s = 0.1; }},
      {"weight", [](auto* p) { p->joints[0].measurements[4].weight = 0.123; }},
      {"gated", [](auto* p) { p->joints[0].measurements[4].gated = true; }},
      {"view", [](auto* p) { p->joints[0].measurements[4].view_slot = 31; }},
      {"camera",
       [&](auto* p) { p->joints[0].measurements[4].camera = &camera; }},
      {"bone", [](auto* p) { p->bones[0].length_m += 1e-9; }},
      {"no bone", [](auto* p) { p->bones.clear(); }}};
  const PersonProblem before = problem;
  for (const auto& [what, change] : changes) {
    problem = before;
    change(&problem);
    expect_another(what, key("a", options_));
  }
  problem = before;
  EXPECT_EQ(keys.count(key("a", options_)), 1u);
}

// Nobody can tell two factors of the caller's own apart.
TEST_F(ChunkPiecesTest, FactorsOfTheCallersOwnHaveNoKey) {
  PersonProblem problem = problem_;
  problem.user.emplace_back();
  EXPECT_EQ(ChunkKey("a", PersonSolver(options_), {0, 250, 0, 250}, problem),
            "");
}

}  // namespace
}  // namespace kinegraph
