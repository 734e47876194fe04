#include "solvers/graph/problem_store.h"

#include <memory>

#include "tests/support/solver_problem.h"

namespace kinegraph {
namespace {

// Nothing of what it says is asked here.
class SomeFactor final : public GeneralFactor {
 public:
  int residual_count() const override { return 1; }
  int state_count() const override { return 2; }
  bool Evaluate(double const* const*, double*, double**) const override {
    return false;
  }
};

void ExpectSame(const PixelMeasurement& a, const PixelMeasurement& b) {
  EXPECT_EQ(a.px, b.px);
  EXPECT_EQ(a.bias_px, b.bias_px);
  EXPECT_EQ(a.sigma_px, b.sigma_px);
  EXPECT_EQ(a.model_sigma_px, b.model_sigma_px);
  EXPECT_EQ(a.log_confidence, b.log_confidence);
  EXPECT_EQ(a.information, b.information);
  EXPECT_EQ(a.offset_s, b.offset_s);
  EXPECT_EQ(a.camera, b.camera);
  EXPECT_EQ(a.view_slot, b.view_slot);
  EXPECT_EQ(a.gated, b.gated);
  EXPECT_EQ(a.weight, b.weight);
}

void ExpectSame(const JointChain& a, const JointChain& b) {
  EXPECT_EQ(a.states, b.states);
  EXPECT_EQ(a.process_noise, b.process_noise);
  EXPECT_EQ(a.first, b.first);
  EXPECT_EQ(a.prior.A, b.prior.A);
  EXPECT_EQ(a.prior.x0, b.prior.x0);
  ASSERT_EQ(a.measurements.size(), b.measurements.size());
  for (size_t m = 0; m < a.measurements.size(); ++m) {
    ExpectSame(a.measurements[m], b.measurements[m]);
  }
}

class ProblemStoreTest : public testing::SolverProblemTest {
 protected:
  // Both ways, with what Make has simulated.
  void AppendBothWays() {
    Assembler direct(scene_, options_);
    Assembler stored(scene_, options_);
    problem_ = direct.EmptyProblem();
    ProblemStore store(stored.EmptyProblem());
    for (const EstimatorFrame& frame : take_.frames) {
      direct.Append(frame, &problem_);
      stored.Append(frame, store.newest());
      // What learns from the newest frame finds it there.
      EXPECT_EQ(store.newest()->times[store.newest_frame()], frame.time);
      store.Keep();
    }
    restored_ = store.TakeAll();
    EXPECT_TRUE(store.TakeAll().times.empty());
  }
  void ExpectSameProblem() const {
    EXPECT_EQ(restored_.times, problem_.times);
    ASSERT_EQ(restored_.joints.size(), problem_.joints.size());
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      ExpectSame(restored_.joints[j], problem_.joints[j]);
    }
    ASSERT_EQ(restored_.user.size(), problem_.user.size());
    for (size_t i = 0; i < problem_.user.size(); ++i) {
      const auto& keys = problem_.user[i].keys;
      ASSERT_EQ(restored_.user[i].keys.size(), keys.size());
      for (size_t s = 0; s < keys.size(); ++s) {
        EXPECT_EQ(restored_.user[i].keys[s].frame, keys[s].frame);
        EXPECT_EQ(restored_.user[i].keys[s].joint, keys[s].joint);
      }
    }
  }

  PersonProblem restored_;
};

TEST_F(ProblemStoreTest, GivesBackEveryBit) {
  testing::SimulatedNoise noise;
  noise.missing = 0.3;
  noise.outliers = 0.1;
  noise.confidence_low = 0.2;
  Rig rig;
  rig.later_each_ns = 3'000'000;
  // Each measurement's information depends on when its view saw it last.
  options_.correlation_time_s = 0.1;
  Make(rig, noise);
  AppendBothWays();
  ExpectSameProblem();
}

TEST_F(ProblemStoreTest, KeepsAUsersFactorsInTheirFrames) {
  options_.user_factors = [](const UserFrame& frame) {
    std::vector<UserFactor> factors;
    if (!frame.has_previous || frame.frame % 3 != 0) return factors;
    UserFactor factor;
    factor.factor = std::make_shared<SomeFactor>();
    factor.states = {{1, 1}, {1, 0}};
    factors.push_back(factor);
    return factors;
  };
  Make({}, {});
  AppendBothWays();
  ASSERT_GE(problem_.user.size(),
            9u);  // every third of 30 frames but the first
  ExpectSameProblem();
}

}  // namespace
}  // namespace kinegraph
