#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"
#include "solvers/batch/recording_solver.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/outcome.h"
#include "solvers/noise/pixel_noise.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

// A recording of a moving arm, half a minute long, with missing joints and a
// gap.
class ChunksTest : public ::testing::Test {
 protected:
  void SetUp() override {
    scene_ = testing::SmallScene(testing::RingOfCameras(5, 5.0, 1000.0), 25.0);
    testing::SimulatedNoise noise;
    noise.correlation_time_s = 0.1;
    noise.missing = 0.1;
    noise.outliers = 0.05;
    noise.outlier_burst = 3;
    noise.confidence_low = 0.3;
    recording_ = testing::Simulate(
        scene_, options_, testing::WalkingMotion(scene_, 750), noise, 61);
    recording_.Connect();
    // No observations for two seconds across the end of a chunk.
    for (size_t k = 165; k < 215; ++k) recording_.frames[k].views.clear();
    problem_ = testing::Assemble(scene_, options_, recording_.frames);
  }

  PersonProblem Solve(double chunk_s, int threads) const {
    GraphOptions options = options_;
    options.chunk_s = chunk_s;
    PersonProblem recording = problem_;
    ParallelFor(threads, 1, [&](int) {
      RecordingSolver solver(options);
      solver.SolveJoints(solver.schedule(), &recording);
    });
    return recording;
  }

  SceneModel scene_;
  GraphOptions options_;
  testing::SimulatedRecording recording_;
  PersonProblem problem_;
};

TEST_F(ChunksTest, EveryFrameIsInOneChunk) {
  for (const double chunk_s : {0.0, 4.0, 10.0, 1000.0}) {
    size_t next = 0;
    for (const Chunk& chunk : MakeChunks(problem_, chunk_s)) {
      EXPECT_EQ(chunk.own_begin, next);
      EXPECT_LT(chunk.own_begin, chunk.own_end);
      EXPECT_LE(chunk.begin, chunk.own_begin);
      EXPECT_GE(chunk.end, chunk.own_end);
      // 1.1 s at 25 Hz, except at the ends of the recording.
      EXPECT_TRUE(chunk.begin == 0 || chunk.own_begin - chunk.begin >= 27);
      EXPECT_TRUE(chunk.end == 750 || chunk.end - chunk.own_end >= 27);
      next = chunk.own_end;
    }
    EXPECT_EQ(next, 750u);
  }
  EXPECT_EQ(MakeChunks(problem_, 0.0).size(), 1u);
  // The recording lasts 29.96 s, and a chunk at least 10 s.
  EXPECT_EQ(MakeChunks(problem_, 10.0).size(), 2u);
  EXPECT_TRUE(MakeChunks(PersonProblem(), 10.0).empty());
}

// 99 % of the observed joints agree with a solve of the whole recording within
// 0.1 mm: frames 28 away have almost no influence.
TEST_F(ChunksTest, StatesMatchASolveOfTheWholeRecording) {
  const PersonProblem whole = Solve(0.0, 1);
  const PersonProblem chunks = Solve(7.0, 1);
  std::vector<double> apart;
  for (size_t j = 0; j < 3; ++j) {
    for (size_t k = 0; k < 750; ++k) {
      if (CountInliers(whole.joints[j], k, options_.inlier_weight) < 2) {
        continue;
      }
      apart.push_back((whole.joints[j].states[k] - chunks.joints[j].states[k])
                          .head<3>()
                          .norm());
    }
  }
  ASSERT_GT(apart.size(), 1500u);
  std::sort(apart.begin(), apart.end());
  EXPECT_LT(apart[apart.size() * 99 / 100], 1e-4);
  // Not bit-identical, so chunks were really solved.
  EXPECT_GT(apart.back(), 0.0);
}

TEST_F(ChunksTest, ResultIsBitwiseIndependentOfThreadCount) {
  const PersonProblem one = Solve(4.0, 1);
  const PersonProblem three = Solve(4.0, 3);
  for (size_t j = 0; j < 3; ++j) {
    for (size_t k = 0; k < 750; ++k) {
      EXPECT_EQ(one.joints[j].states[k], three.joints[j].states[k]);
    }
  }
}

TEST_F(ChunksTest, CovariancesMatchASolveOfTheWholeRecording) {
  const PersonProblem solved = Solve(0.0, 1);
  std::vector<std::vector<std::vector<Matrix6d>>> covariances;
  for (const double chunk_s : {0.0, 7.0}) {
    GraphOptions options = options_;
    options.chunk_s = chunk_s;
    covariances.push_back(
        RecordingSolver(options).StateCovariances(solved, 1.1));
  }
  for (size_t j = 0; j < 3; ++j) {
    ASSERT_EQ(covariances[0][j].size(), 750u);
    ASSERT_EQ(covariances[1][j].size(), 750u);
    for (size_t k = 0; k < 750; ++k) {
      const Matrix6d& whole = covariances[0][j][k];
      // Skips frames without two inlier views, such as those of the gap: the
      // overlap of the chunk that ends in the gap contains observations from
      // only half a second after the gap.
      if (CountInliers(solved.joints[j], k, options_.inlier_weight) < 2) {
        continue;
      }
      EXPECT_LT((covariances[1][j][k] - whole).norm(), 1e-3 * whole.norm());
    }
  }
}

}  // namespace
}  // namespace kinegraph
