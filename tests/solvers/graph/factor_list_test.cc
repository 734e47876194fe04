// Compares the number and the cost of a person's factors with hand-computed
// values.
#include "solvers/graph/factor_list.h"

#include <gtest/gtest.h>

#include <cmath>
#include <type_traits>

#include "tests/support/solver_problem.h"

namespace kinegraph {
namespace {

// At the origin, looking along +z, focal length 1000 px, centre (0, 0).
Camera OriginCamera() {
  CameraParameters parameters;
  parameters.name = "origin";
  parameters.K << 1000.0, 0.0, 0.0, 0.0, 1000.0, 0.0, 0.0, 0.0, 1.0;
  return Camera(parameters);
}

State At(double x, double y, double z, double vx, double vz) {
  State state;
  state << x, y, z, vx, 0.0, vz;
  return state;
}

PixelMeasurement Seen(const Camera* camera, double x_px, double offset_s) {
  PixelMeasurement measurement;
  measurement.camera = camera;
  measurement.px = {x_px, 0.0};
  measurement.offset_s = offset_s;
  return measurement;
}

// Three frames of two joints 5 m from a camera. Joint 0 moves along x by 1
// m/s, 1 m from its prior; joint 1 rests at its prior, 1 m from the body's
// centre, and has a velocity of 1 m/s in the last frame.
PersonProblem TwoJoints(const Camera* camera) {
  PersonProblem person;
  person.times = {FromSeconds(0.0), FromSeconds(0.1), FromSeconds(0.3)};
  person.centres.assign(3, {Eigen::Vector3d(0.0, 0.0, 5.0), 2.0});
  person.joints.resize(2);
  JointChain& moving = person.joints[0];
  moving.states = {At(0.0, 0.0, 5.0, 1.0, 0.0), At(0.1, 0.0, 5.0, 1.0, 0.0),
                   At(0.3, 0.0, 5.0, 1.0, 0.0)};
  moving.process_noise = {2.0, 2.0};
  moving.prior.x0 = At(-1.0, 0.0, 5.0, 1.0, 0.0);
  // The first frame has a measurement with an error of 3 px and half the
  // information, one captured 0.1 s later, and a gated one. The second frame
  // has none.
  moving.measurements = {Seen(camera, 3.0, 0.0), Seen(camera, 20.0, 0.1),
                         Seen(camera, 500.0, 0.0), Seen(camera, 60.0, 0.0)};
  moving.measurements[0].information = 0.5;
  moving.measurements[2].gated = true;
  moving.first = {0, 3, 3, 4};
  JointChain& resting = person.joints[1];
  resting.states = {At(0.0, 1.0, 5.0, 0.0, 0.0), At(0.0, 1.0, 5.0, 0.0, 0.0),
                    At(0.0, 1.0, 5.0, 0.0, 1.0)};
  resting.process_noise = {2.0, 2.0};
  resting.prior.x0 = resting.states[0];
  resting.first = {0, 0, 0, 0};
  person.bones = {{0, 1, 1.0, 0.5}};
  return person;
}

struct Counted {
  int priors = 0, centres = 0, motions = 0, pixels = 0, bones = 0;
  double cost = 0.0;
};

Counted Count(const PersonProblem& person, const FactorWalk& walk) {
  Counted counted;
  const auto add = [&](const auto& factor, const auto& keys,
                       const Robustness& robustness) {
    using Factor = std::decay_t<decltype(factor)>;
    counted.priors += std::is_same_v<Factor, GaussianPrior<double>>;
    counted.centres += std::is_same_v<Factor, BodyCentre<double>>;
    counted.motions += std::is_same_v<Factor, ConstantVelocity<double>>;
    counted.pixels += std::is_same_v<Factor, CameraReprojection>;
    counted.bones += std::is_same_v<Factor, BoneLength<double>>;
    Linearised<Factor> at;
    if (!LineariseFactor(factor, keys, person, &at)) return false;
    counted.cost += 0.5 * robustness.information *
                    robustness.Evaluate(at.squared_norm()).rho;
    return true;
  };
  EXPECT_TRUE(testing::ForEachFactor(person, walk, add));
  return counted;
}

TEST(FactorList, CountAndCostMatchHandComputedValues) {
  const Camera camera = OriginCamera();
  PersonProblem person = TwoJoints(&camera);
  const Counted all = Count(person, FactorWalk());
  EXPECT_EQ(all.priors, 2);
  EXPECT_EQ(all.centres, 6);
  EXPECT_EQ(all.motions, 4);
  EXPECT_EQ(all.pixels, 3);
  EXPECT_EQ(all.bones, 3);
  const double priors = 0.5 * 1.0;  // joint 0 is a metre from its prior
  // Residuals: twice 0, 0.1 and 0.3 m for joint 0, and twice 1 m for joint 1.
  const double centres = 0.5 * (0.0 + 0.04 + 0.36) + 0.5 * (4.0 + 4.0 + 4.0);
  // With white noise of power q on acceleration, the information on a change of
  // velocity is 4 / (q dt): here 1 m/s within 0.2 s.
  const double motions = 0.5 * 4.0 / (2.0 * 0.2);
  const double pixels = 0.5 * 0.5 * 9.0;
  // The bone is a metre at first, then 1.01^0.5 and 1.09^0.5 m.
  const double bones = 0.5 * (std::pow((std::sqrt(1.01) - 1.0) / 0.5, 2) +
                              std::pow((std::sqrt(1.09) - 1.0) / 0.5, 2));
  // Sums of a few terms below ten have rounding errors of about 1e-15.
  EXPECT_NEAR(all.cost, priors + centres + motions + pixels + bones, 1e-12);

  // The loss applies to pixels only: Cauchy's at 3 sigmas with scale 2 is 4
  // log(1 + 9/4).
  FactorWalk walk;
  walk.stage.loss = LossKind::kCauchy;
  walk.stage.scale = 2.0;
  const double robust = 0.5 * 0.5 * 4.0 * std::log(1.0 + 9.0 / 4.0);
  EXPECT_NEAR(Count(person, walk).cost,
              priors + centres + motions + robust + bones, 1e-12);
}

TEST(FactorList, EndsBeforeAFrame) {
  const Camera camera = OriginCamera();
  PersonProblem person = TwoJoints(&camera);
  FactorWalk walk;
  walk.end = 1;
  const Counted first = Count(person, walk);
  EXPECT_EQ(first.priors, 2);
  EXPECT_EQ(first.centres, 2);
  EXPECT_EQ(first.motions, 2);  // to the second frame
  EXPECT_EQ(first.pixels, 2);
  EXPECT_EQ(first.bones, 1);
  walk.end = 3;
  EXPECT_EQ(Count(person, walk).cost, Count(person, FactorWalk()).cost);
}

TEST(FactorList, PersonPriorReplacesJointPriors) {
  const Camera camera = OriginCamera();
  PersonProblem person = TwoJoints(&camera);
  person.prior.A = Eigen::MatrixXd::Identity(12, 12);
  const Counted counted = Count(person, FactorWalk());
  EXPECT_EQ(counted.priors, 0);
  EXPECT_EQ(counted.motions, 4);
}

TEST(FactorList, StopsAtAnUndefinedFactor) {
  const Camera camera = OriginCamera();
  PersonProblem person = TwoJoints(&camera);
  person.joints[0].states[2].z() = -1.0;  // behind the camera
  int visited = 0;
  const auto visit = [&](const auto& factor, const auto& keys,
                         const Robustness&) {
    ++visited;
    Linearised<std::decay_t<decltype(factor)>> at;
    return LineariseFactor(factor, keys, person, &at);
  };
  EXPECT_FALSE(testing::ForEachFactor(person, FactorWalk(), visit));
  EXPECT_LT(visited, 18);  // of the whole list
}

}  // namespace
}  // namespace kinegraph
