// Tests the priors, measurements and user factors of a PersonProblem.
#include "solvers/graph/problem.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "solvers/graph/outcome.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

// Two frames of a joint at rest, seen by all cameras of a ring.
struct SmallChain {
  CameraRig cameras = testing::RingOfCameras(3);
  JointChain chain;

  SmallChain() {
    State state = State::Zero();
    state.head<3>() << 0.2, -0.1, 1.0;
    chain.states.assign(2, state);
    for (int k = 0; k < 2; ++k) {
      for (int16_t v = 0; v < 3; ++v) {
        PixelMeasurement one;
        one.camera = &cameras[static_cast<size_t>(v)];
        one.px = *one.camera->Project(state.head<3>());
        one.sigma_px = 2.0;
        one.view_slot = v;
        one.weight = 1.0;
        chain.measurements.push_back(one);
      }
      chain.first.push_back(static_cast<int32_t>(chain.measurements.size()));
    }
  }
  PixelMeasurement& At(size_t frame, size_t view) {
    return chain.measurements[3 * frame + view];
  }
};

// ---- Priors ----

TEST(BirthPrior, ScalesPositionsAndVelocitiesByTheSigmas) {
  const Eigen::Vector3d centre(1.0, -2.0, 0.5);
  const StatePrior prior = BirthPrior(centre, 0.5, 4.0);
  State state;
  state << centre + Eigen::Vector3d(1.0, 0.0, -0.5), 8.0, -4.0, 0.0;
  const State residual = prior.A * (state - prior.x0) + prior.b;
  State expected;
  expected << 2.0, 0.0, -1.0, 2.0, -1.0, 0.0;
  EXPECT_LT((residual - expected).norm(), 1e-14);
  EXPECT_EQ(prior.A_stated, prior.A);
}

// ---- Measurements ----

TEST(GateMeasurements, GatesExactlyTheViewsWithoutAProjectionOfTheState) {
  SmallChain small;
  const State seen = small.chain.states[1];
  small.chain.states[1].head<3>() = 1.5 * small.cameras[1].centre();
  GateMeasurements(&small.chain);
  for (size_t v = 0; v < 3; ++v) {
    EXPECT_FALSE(small.At(0, v).gated);
    EXPECT_EQ(small.At(1, v).gated, v == 1) << v;
  }
  small.chain.states[1] = seen;
  GateMeasurements(&small.chain);
  EXPECT_FALSE(small.At(1, 1).gated);
}

TEST(StoreWeights, WeightsAreTheDerivativesOfTheLoss) {
  SmallChain small;
  small.At(0, 1).px.x() += 12.0;  // six sigmas
  small.At(1, 2).gated = true;
  const double scale = 3.0;
  for (const LossKind loss : {LossKind::kNone, LossKind::kHuber,
                              LossKind::kCauchy, LossKind::kGemanMcClure}) {
    StoreWeights({loss, scale, 10}, &small.chain);
    EXPECT_DOUBLE_EQ(small.At(0, 0).weight, 1.0);
    EXPECT_EQ(small.At(1, 2).weight, 0.0);
    const double s = 36.0;
    // The derivative of rho(s) by central differences; third derivatives are
    // below 1e-2.
    constexpr double kStep = 1e-3;
    const double numeric = (EvaluateLoss(loss, scale, s + kStep).rho -
                            EvaluateLoss(loss, scale, s - kStep).rho) /
                           (2.0 * kStep);
    EXPECT_NEAR(small.At(0, 1).weight, numeric, 1e-7);
  }
}

TEST(DoubtUnsettled, ZeroesTheWeightsOfMovingStates) {
  SmallChain small;
  StateChain step(2, State::Zero());
  // Velocities do not count; positions do from 5 cm on.
  step[0].tail<3>().setConstant(9.0);
  step[1][2] = -0.049;
  EXPECT_EQ(DoubtUnsettled(step, &small.chain), 0);
  EXPECT_EQ(small.At(1, 0).weight, 1.0);
  for (const int axis : {0, 1, 2, 3, 4, 5}) {
    SmallChain other;
    step[1].setZero();
    const double moved_m = axis < 3 ? -0.051 : std::nan("");
    step[1][axis % 3] = moved_m;
    EXPECT_EQ(DoubtUnsettled(step, &other.chain), 1) << moved_m;
    for (size_t v = 0; v < 3; ++v) {
      EXPECT_EQ(other.At(0, v).weight, 1.0);
      EXPECT_EQ(other.At(1, v).weight, 0.0);
    }
  }
}

// ---- A user's factors ----

// Residual: twice the first coordinate of each state, summed; undefined beyond
// 100 m.
class SumFactor : public GeneralFactor {
 public:
  explicit SumFactor(int states) : states_(states) {}
  int residual_count() const override { return 1; }
  int state_count() const override { return states_; }
  bool Evaluate(double const* const* states, double* residual,
                double** jacobians) const override {
    residual[0] = 0.0;
    for (int i = 0; i < states_; ++i) {
      if (std::abs(states[i][0]) > 100.0) return false;
      residual[0] += 2.0 * states[i][0];
      if (jacobians == nullptr || jacobians[i] == nullptr) continue;
      for (int k = 0; k < kStateSize; ++k) jacobians[i][k] = k == 0 ? 2.0 : 0.0;
    }
    return true;
  }

 private:
  int states_;
};

// `state_count`: the number of states that the factor itself depends on.
UserFactor FactorOn(std::vector<UserState> states, int state_count) {
  UserFactor factor;
  factor.factor = std::make_shared<SumFactor>(state_count);
  factor.states = std::move(states);
  factor.loss = LossKind::kCauchy;
  factor.loss_scale = 2.0;
  return factor;
}

std::vector<PlacedFactor> Placed(const UserFactor& factor, bool has_previous,
                                 size_t k) {
  UserFrame frame;
  frame.has_previous = has_previous;
  return PlaceUserFactors(
      [&](const UserFrame&) { return std::vector<UserFactor>{factor}; }, frame,
      k, 3);
}

TEST(PlaceUserFactors, CountsFramesBackFromTheCurrentFrame) {
  const auto placed = Placed(FactorOn({{2, 0}, {1, 1}}, 2), true, 7);
  ASSERT_EQ(placed.size(), 1u);
  EXPECT_EQ(placed[0].keys[0].joint, 2);
  EXPECT_EQ(placed[0].keys[0].frame, 7u);
  EXPECT_EQ(placed[0].keys[1].joint, 1);
  EXPECT_EQ(placed[0].keys[1].frame, 6u);
  EXPECT_EQ(placed[0].first_frame(), 6u);
  EXPECT_EQ(placed[0].last_frame(), 7u);
  EXPECT_EQ(placed[0].robustness.loss, LossKind::kCauchy);
  EXPECT_EQ(placed[0].robustness.scale, 2.0);
}

TEST(PlaceUserFactors, RefusesUnknownJointsFramesAndWrongSizes) {
  EXPECT_THROW(Placed(FactorOn({{3, 0}}, 1), true, 7), OptionError);
  EXPECT_THROW(Placed(FactorOn({{-1, 0}}, 1), true, 7), OptionError);
  EXPECT_THROW(Placed(FactorOn({{0, 2}}, 1), true, 7), OptionError);
  EXPECT_THROW(Placed(FactorOn({{0, 1}}, 1), false, 0), OptionError);
  EXPECT_THROW(Placed(FactorOn({{0, 0}}, 2), true, 7), OptionError);
  EXPECT_THROW(Placed(FactorOn({}, 0), true, 7), OptionError);
  EXPECT_THROW(Placed(UserFactor(), true, 7), OptionError);
}

// Ceres ends the process if a block depends on a state twice.
TEST(PlaceUserFactors, RefusesAStateTwiceAndLossesWithoutScale) {
  EXPECT_THROW(Placed(FactorOn({{2, 0}, {1, 0}, {2, 0}}, 3), true, 7),
               OptionError);
  EXPECT_NO_THROW(Placed(FactorOn({{2, 0}, {2, 1}}, 2), true, 7));
  UserFactor factor = FactorOn({{2, 0}}, 1);
  for (const double scale : {0.0, -1.0, std::nan("")}) {
    factor.loss_scale = scale;
    EXPECT_THROW(Placed(factor, true, 7), OptionError);
  }
}

TEST(LineariseGeneral, ScalesRowsByTheRootOfTheWeight) {
  PersonProblem problem;
  problem.joints.resize(3);
  for (JointChain& joint : problem.joints)
    joint.states.assign(2, State::Zero());
  problem.joints[2].states[1][0] = 0.75;
  problem.joints[1].states[0][0] = 0.25;
  const PlacedFactor placed = Placed(FactorOn({{2, 0}, {1, 1}}, 2), true, 1)[0];
  GeneralRows rows;
  ASSERT_TRUE(LineariseGeneral(placed, problem, &rows));
  // The residual is 2, as large as the loss's scale: Cauchy's weight is a half.
  const double root = std::sqrt(0.5);
  EXPECT_DOUBLE_EQ(rows.residual[0], 2.0 * root);
  for (const auto& by_state : rows.by_states) {
    EXPECT_DOUBLE_EQ(by_state(0, 0), 2.0 * root);
    EXPECT_EQ(by_state.rightCols(5).norm(), 0.0);
  }
  problem.joints[1].states[0][0] = 101.0;
  EXPECT_FALSE(LineariseGeneral(placed, problem, &rows));
}

TEST(PersonProblem, IsCoupledByBonesPriorsOrUserFactors) {
  PersonProblem problem;
  EXPECT_FALSE(problem.coupled());
  PersonProblem bones = problem;
  bones.bones.emplace_back();
  EXPECT_TRUE(bones.coupled());
  PersonProblem prior = problem;
  prior.prior.A.setIdentity(6, 6);
  EXPECT_TRUE(prior.coupled());
  problem.user.emplace_back();
  EXPECT_TRUE(problem.coupled());
}

TEST(SolveSchedule, EarlierStagesHaveThirtyTimesTheTolerance) {
  SolveSchedule schedule;
  schedule.stages.resize(3);
  schedule.step_tolerance_m = 2e-5;
  EXPECT_DOUBLE_EQ(schedule.StepToleranceM(0), 6e-4);
  EXPECT_DOUBLE_EQ(schedule.StepToleranceM(1), 6e-4);
  EXPECT_DOUBLE_EQ(schedule.StepToleranceM(2), 2e-5);
}

}  // namespace
}  // namespace kinegraph
