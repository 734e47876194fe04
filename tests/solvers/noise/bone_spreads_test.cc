#include "solvers/noise/bone_spreads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

constexpr double kLength = 0.42;  // m

Skeleton Legs() {
  return Skeleton("legs",
                  {"l_knee", "l_ankle", "r_knee", "r_ankle", "l_hip", "r_hip"},
                  {{0, 1}, {2, 3}});
}

// Observations of a bone with Gaussian noise; each end is seen by four views.
class BoneSimulator {
 public:
  explicit BoneSimulator(uint64_t seed) : random_(seed) {}

  double noise_m = 0.01;     // true sigma of the length
  double modelled_m = 0.01;  // sigma in the model
  double correlation = 0.0;  // of consecutive observations' noise

  BoneObservation At(double length_m) {
    state_ = started_ ? correlation * state_ +
                            std::sqrt(1.0 - correlation * correlation) *
                                random_.Normal()
                      : random_.Normal();
    started_ = true;
    BoneObservation observation;
    observation.distance_m = length_m + noise_m * state_;
    observation.variance_m2 = modelled_m * modelled_m;
    observation.freedom = 10;
    const double ratio = noise_m / modelled_m;
    for (int i = 0; i < observation.freedom; ++i) {
      const double residual = ratio * random_.Normal();
      observation.square += residual * residual;
    }
    observation.averaged_frames = 6.0;
    return observation;
  }

 private:
  Random random_;
  double state_ = 0.0;
  bool started_ = false;
};

// The estimate from `count` observations of a bone whose length varies by
// `varies_m`.
BoneEstimate EstimateFrom(BoneSimulator simulator, int count,
                          double varies_m = 0.0) {
  Random random(7);
  BoneSpreads spreads(Legs());
  for (int i = 0; i < count; ++i) {
    spreads.Add(0, simulator.At(kLength + varies_m * random.Normal()));
  }
  return *spreads.Estimate(0);
}

TEST(BoneSpreads, RigidBoneHasNoSpread) {
  for (const double modelled : {0.005, 0.01, 0.03}) {
    BoneSimulator simulator(1);
    simulator.modelled_m = modelled;  // the residuals reveal the error
    const BoneEstimate estimate = EstimateFrom(simulator, 1000);
    // The median of 1000 observations with errors of 1 cm is accurate to 0.4
    // mm.
    EXPECT_NEAR(estimate.length_sigma_m, 0.0004, 0.0001);
    EXPECT_NEAR(estimate.length_m, kLength, 4 * 0.0004);
    // The variance of 1000 observations has a standard error of 6 % of 1 cm^2,
    // and the residuals' scale one of a few per cent, so the spread may reach 4
    // standard errors, sqrt(0.3) cm.
    EXPECT_LT(estimate.spread_m, 0.0055);
    EXPECT_GE(estimate.spread_bound_m, estimate.spread_m);
    EXPECT_LT(estimate.spread_bound_m, 0.0065);
    EXPECT_FALSE(estimate.gives_way);
  }
}

// The residuals reveal a model that is wrong by a factor of two.
TEST(BoneSpreads, SpreadIsSeparatedFromNoise) {
  for (const double modelled_m : {0.01, 0.02}) {
    BoneSimulator simulator(2);
    simulator.modelled_m = modelled_m;
    // (1 cm)^2 + (2 cm)^2 has a standard error of 6 %, so (2 cm)^2 has one of
    // 7.5 %; four standard errors are 15 % of 2 cm.
    EXPECT_NEAR(EstimateFrom(simulator, 1000, 0.02).spread_m, 0.02, 0.003)
        << modelled_m;
  }
}

TEST(BoneSpreads, ResistsOutliers) {
  BoneSimulator simulator(3);
  BoneSpreads spreads(Legs());
  for (int i = 0; i < 1000; ++i) {
    BoneObservation observation = simulator.At(kLength);
    if (i % 10 == 0) {
      observation.distance_m += 0.3;
      observation.square += 1000.0;
    }
    spreads.Add(0, observation);
  }
  const BoneEstimate estimate = *spreads.Estimate(0);
  // A tenth of the values on one side moves the median to the quantile 5/9, by
  // 0.14 sigma.
  EXPECT_NEAR(estimate.length_m, kLength, 0.0014 + 4 * 0.0004);
  // The upper quartile of the others moves to 5/6 (chi-square 1.91 instead of
  // 1.32), an apparent spread of sqrt(0.45) cm.
  EXPECT_LT(estimate.spread_m, 0.0067 + 0.003);
}

// One end of a bone along x, located with independent Gaussian noise of these
// standard deviations; the solver's estimate averages nine frames.
BoneEnd LocatedAt(double x_m, const Vector3d& noise_m, double modelled,
                  Random* random) {
  BoneEnd end;
  end.position_m = end.estimate_m = Vector3d(x_m, 0.0, 0.0);
  for (int i = 0; i < 3; ++i) {
    end.position_m[i] += noise_m[i] * random->Normal();
    end.estimate_m[i] += noise_m[i] / 3.0 * random->Normal();
  }
  end.covariance_m2 =
      modelled * modelled * noise_m.cwiseAbs2().asDiagonal().toDenseMatrix();
  end.freedom = 5;
  for (int i = 0; i < end.freedom; ++i) {
    const double residual = random->Normal() / modelled;
    end.square += residual * residual;
  }
  return end;
}

// The estimate from 1000 observations of ends located in this way, and the mean
// distance.
BoneEstimate EstimateFromEnds(double length_m, const Vector3d& noise_m,
                              double modelled, Random* random,
                              double* distance_m = nullptr) {
  BoneSpreads spreads(Legs());
  double sum_m = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const auto observation =
        LookAtBone(LocatedAt(0.0, noise_m, modelled, random),
                   LocatedAt(length_m, noise_m, modelled, random));
    EXPECT_TRUE(observation.has_value());
    sum_m += observation->distance_m;
    spreads.Add(0, *observation);
  }
  if (distance_m != nullptr) *distance_m = sum_m / 1000.0;
  return *spreads.Estimate(0);
}

TEST(BoneSpreads, NoiseDoesNotIncreaseTheLength) {
  Random random(11);
  for (const double noise : {0.05, 0.15, 0.3}) {
    for (const double modelled : {0.5, 1.0, 2.0}) {
      double distances = 0.0;
      const BoneEstimate estimate = EstimateFromEnds(
          kLength, Vector3d::Constant(noise), modelled, &random, &distances);
      // Four standard errors, plus 5 % of the noise's bias, tr N / (2 L) for a
      // bone vector with the covariance N, for the error of the noise scale.
      const double trace = 6.0 * noise * noise;
      const double bound =
          4.0 * estimate.length_sigma_m + 0.05 * trace / (2.0 * kLength);
      EXPECT_NEAR(estimate.length_m, kLength, bound) << noise;
      EXPECT_LT(bound, 0.5 * kLength);
      if (noise > 0.1) {
        EXPECT_GT(distances, kLength + 0.04)
            << "the mean distance is biased by the noise";
      }
      EXPECT_FALSE(estimate.gives_way);
      EXPECT_TRUE(std::isfinite(estimate.spread_bound_m));
    }
  }
}

// Two cameras side by side are much less accurate in depth. Noise in depth
// rotates and lengthens a bone that is perpendicular to the viewing direction;
// along its observed direction the bone would then appear noisier than it is.
TEST(BoneSpreads, NoiseInDepthDoesNotReduceTheLength) {
  constexpr double kShort_m = 0.2;
  const Vector3d noise_m(0.01, 0.045, 0.01);
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const BoneEstimate estimate =
        EstimateFromEnds(kShort_m, noise_m, 1.0, &random);
    // As in NoiseDoesNotIncreaseTheLength. With the noise along the observed
    // instead of the estimated directions, the length would be 4 mm too short.
    const double bound =
        4.0 * estimate.length_sigma_m + 0.05 * noise_m.squaredNorm() / kShort_m;
    EXPECT_NEAR(estimate.length_m, kShort_m, bound) << seed;
    EXPECT_LT(bound, 0.005);
  }
}

TEST(BoneSpreads, BoneShorterThanTheNoiseIsUnknown) {
  // Both ends at the same position and too much modelled noise: the corrected
  // square is negative.
  Random random(12);
  const Skeleton strange("strange", {"l_tip", "l_end", "r_tip", "r_end"},
                         {{0, 1}, {2, 3}});
  BoneSpreads spreads(strange);
  const Vector3d noise_m = Vector3d::Constant(0.01);
  for (int i = 0; i < 100; ++i) {
    BoneObservation observation =
        *LookAtBone(LocatedAt(0.0, noise_m, 1.0, &random),
                    LocatedAt(0.0, noise_m, 1.0, &random));
    observation.noise_m2 *= 3.0;
    spreads.Add(0, observation);
  }
  EXPECT_FALSE(spreads.Estimate(0).has_value());
}

TEST(BoneSpreads, CorrelatedObservationsCountLess) {
  BoneSimulator independent(4);
  BoneSimulator lasting(4);
  lasting.correlation = 0.9;
  const BoneEstimate a = EstimateFrom(independent, 1000);
  const BoneEstimate b = EstimateFrom(lasting, 1000);
  // (1 + 0.9) / (1 - 0.9) = 19 observations count as one, which increases the
  // error by a factor of 4.4; the tolerance allows for the error of the
  // estimated correlation.
  EXPECT_NEAR(b.length_sigma_m / a.length_sigma_m, 4.4, 1.0);
  EXPECT_GT(b.spread_bound_m, a.spread_bound_m);
}

TEST(BoneSpreads, ConstantErrorsIncreaseTheLengthSigma) {
  constexpr double kFrame_s = 0.01;
  BoneSimulator simulator(5);
  BoneSpreads spreads(Legs());
  for (int i = 0; i < 1000; ++i) spreads.Add(0, simulator.At(kLength));
  const double averaged_m = spreads.Estimate(0)->length_sigma_m;
  // A quarter of the variance is constant, i.e. half of an observation's sigma
  // of 1 cm. The scale of the observations is known to a few per cent (see
  // RigidBoneHasNoSpread).
  spreads.SetLasting({0.25, 1e6}, kFrame_s);
  EXPECT_NEAR(spreads.Estimate(0)->length_sigma_m, 0.005, 0.0003);
  // With a correlation time of a fiftieth of these ten seconds, 2 * 0.2 / 10 of
  // this variance remains.
  spreads.SetLasting({0.25, 0.2}, kFrame_s);
  EXPECT_NEAR(spreads.Estimate(0)->length_sigma_m, 0.001, 0.0001);
  // With so short a correlation time, the deviations alone determine the sigma.
  spreads.SetLasting({0.25, 0.001}, kFrame_s);
  EXPECT_EQ(spreads.Estimate(0)->length_sigma_m, averaged_m);
}

TEST(BoneSpreads, UnseenBoneUsesTheOtherSide) {
  BoneSimulator simulator(5);
  BoneSpreads spreads(Legs());
  for (int i = 0; i < 800; ++i) spreads.Add(0, simulator.At(kLength));
  const BoneEstimate right = *spreads.Estimate(1);
  EXPECT_NEAR(right.length_m, kLength, 0.003)
      << "the population's length is 0.418 m";
  EXPECT_GT(right.length_sigma_m, 0.009) << "sides differ by a centimetre";
  // With many observations of both sides, each keeps its length: the median of
  // 800 observations with errors of 1 cm has a standard error of 0.44 mm.
  for (int i = 0; i < 800; ++i) spreads.Add(1, simulator.At(kLength + 0.03));
  EXPECT_NEAR(spreads.Estimate(0)->length_m, kLength, 0.002);
  EXPECT_NEAR(spreads.Estimate(1)->length_m, kLength + 0.03, 0.002);
}

TEST(BoneSpreads, PopulationPriorWithoutObservations) {
  BoneSpreads spreads(Legs());
  const BoneEstimate estimate = *spreads.Estimate(0);
  EXPECT_DOUBLE_EQ(estimate.length_m, 0.246 * 1.70);
  EXPECT_NEAR(estimate.length_sigma_m, 0.15 * 0.246 * 1.70, 1e-12);
}

TEST(BoneSpreads, AnimalsHaveNoPopulationPrior) {
  std::vector<std::string> joints = Legs().joints();
  joints.emplace_back("tail_base");
  const BoneSpreads spreads(Skeleton("animal", joints, Legs().bones()));
  EXPECT_FALSE(spreads.Estimate(0).has_value());
}

TEST(BoneSpreads, BonesWithoutAPriorNeedObservations) {
  BoneSimulator simulator(6);
  BoneSpreads spreads(Skeleton("face", {"nose", "chin"}, {{0, 1}}));
  EXPECT_FALSE(spreads.Estimate(0).has_value());
  for (int i = 0; i < 24; ++i) spreads.Add(0, simulator.At(0.1));
  EXPECT_FALSE(spreads.Estimate(0).has_value());
  spreads.Add(0, simulator.At(0.1));
  ASSERT_TRUE(spreads.Estimate(0).has_value());
  // The median of 25 observations with errors of 1 cm is accurate to 2.5 mm.
  EXPECT_NEAR(spreads.Estimate(0)->length_m, 0.1, 0.01);
}

// A run scales subjects other than people to 1.7 m (subject_scale.h), which is
// the length of the only bone of a subject of two joints.
TEST(BoneLengths, LongBoneIsKnown) {
  BoneLengths lengths(Skeleton("wand", {"top", "grip"}, {{0, 1}}));
  lengths.Add(0, 1.7, 2.0);
  ASSERT_TRUE(lengths.Length(0).has_value());
  EXPECT_NEAR(*lengths.Length(0), 1.7, 0.002);
}

TEST(BoneSpreads, BoneWithLargeSpreadIsNotUsed) {
  EXPECT_TRUE(EstimateFrom(BoneSimulator(8), 500, 0.12).gives_way);
}

TEST(BoneSpreads, ThinningKeepsEarlyObservations) {
  BoneSimulator simulator(10);
  BoneSpreads spreads(Legs());
  // The bone is longer in the first third of the observations; the median lies
  // in the other two thirds.
  for (int i = 0; i < 30000; ++i) {
    spreads.Add(0, simulator.At(i < 10000 ? kLength + 0.06 : kLength));
  }
  const BoneEstimate estimate = *spreads.Estimate(0);
  EXPECT_NEAR(estimate.length_m, kLength, 0.01);
  EXPECT_GT(estimate.spread_m, 0.02)
      << "observations of the first third are kept";
}

TEST(BoneSpreads, RepeatedEstimatesDoNotChangeTheState) {
  BoneSimulator once(11);
  BoneSimulator often(11);
  BoneSpreads a(Legs());
  BoneSpreads b(Legs());
  for (int i = 0; i < 400; ++i) {
    a.Add(0, once.At(kLength));
    b.Add(0, often.At(kLength));
    (void)b.Estimate(0);
  }
  // Estimates are recomputed when the number of observations has grown by a
  // tenth, for the last time with at least 364, whose median differs by less
  // than its error.
  EXPECT_NEAR(a.Estimate(0)->length_m, b.Estimate(0)->length_m, 0.0007);
}

TEST(BoneSpreads, HeadIsRigid) {
  // COCO-17 has 18 bones, four of them among the five joints of the head; the
  // other six pairs of these joints are added.
  const std::vector<Bone> pairs = RigidPairs(Coco17());
  EXPECT_EQ(pairs.size(), Coco17().bones().size() + 6);
  BoneSpreads spreads(Coco17());
  EXPECT_EQ(spreads.bones().size(), pairs.size());
  // The pairs nose to left ear and nose to right ear mirror each other.
  const auto find = [&](int a, int b) {
    for (size_t i = 0; i < pairs.size(); ++i) {
      if (pairs[i].a == a && pairs[i].b == b) return static_cast<int>(i);
    }
    return -1;
  };
  ASSERT_GE(find(0, 3), 0);
  ASSERT_GE(find(0, 4), 0);
  BoneSimulator simulator(12);
  for (int i = 0; i < 200; ++i) spreads.Add(find(0, 3), simulator.At(0.15));
  ASSERT_TRUE(spreads.Estimate(find(0, 4)).has_value());
  EXPECT_NEAR(spreads.Estimate(find(0, 4))->length_m, 0.15, 0.004);
}

// Nine frames with a common spread together have the information of one spread
// of 5 mm. Spread that the observations cannot exclude counts less, with the
// fourth root of the number of frames. An error of the length is common to all
// frames; in reported covariances nine frames have no more information than the
// length itself.
TEST(BoneSpreads, ConstraintSigmaMatchesHandComputedValues) {
  struct Case {
    double spread_m, bound_m, length_sigma_m, frames;
    BoneUse use;
    double sigma_m;
  };
  for (const Case& one :
       {Case{0.005, 0.005, 0.0, 9.0, BoneUse::kEstimate, 0.015},
        Case{0.005, 0.005, 0.0, 16.0, BoneUse::kEstimate, 0.02},
        Case{0.0, 0.005, 0.0, 16.0, BoneUse::kEstimate, 0.01},
        Case{0.0, 0.005, 0.003, 16.0, BoneUse::kEstimate,
             std::hypot(0.01, 0.003)},
        Case{0.0, 0.0, 0.004, 9.0, BoneUse::kEstimate, 0.004},
        Case{0.0, 0.0, 0.004, 9.0, BoneUse::kCovariance, 0.012}}) {
    BoneEstimate estimate;
    estimate.length_m = 0.4;
    estimate.spread_m = one.spread_m;
    estimate.spread_bound_m = one.bound_m;
    estimate.length_sigma_m = one.length_sigma_m;
    estimate.averaged_frames = one.frames;
    const BoneConstraint constraint = ConstraintOf({2, 5}, estimate, one.use);
    EXPECT_EQ(constraint.a, 2);
    EXPECT_EQ(constraint.b, 5);
    EXPECT_EQ(constraint.length_m, 0.4);
    EXPECT_NEAR(constraint.sigma_m, one.sigma_m, 1e-12);
  }
}

// Four bones, three of which provide the prior of the fourth.
Skeleton FourBones() {
  return Skeleton("four", {"a", "b", "c", "d", "e"},
                  {{0, 1}, {1, 2}, {2, 3}, {3, 4}});
}

TEST(BoneSpreads, PoolingRigidBonesTightensSpreadBounds) {
  double alone_m2 = 0.0;
  double together_m2 = 0.0;
  for (uint64_t seed = 20; seed < 40; ++seed) {
    BoneSimulator simulator(seed);
    BoneSpreads alone(Legs());
    BoneSpreads together(FourBones());
    for (int i = 0; i < 150; ++i) {
      const BoneObservation observation = simulator.At(kLength);
      alone.Add(0, observation);
      together.Add(0, observation);
      for (int b = 1; b < 4; ++b) together.Add(b, simulator.At(kLength));
    }
    alone_m2 += std::pow(alone.Estimate(0)->spread_bound_m, 2);
    together_m2 += std::pow(together.Estimate(0)->spread_bound_m, 2);
  }
  // Four estimates of the same spread halve the standard error of its variance;
  // their random differences reduce the gain.
  EXPECT_LT(together_m2, 0.75 * alone_m2);
}

TEST(BoneSpreads, VaryingBoneIsNotShrunkToRigidBones) {
  BoneSimulator simulator(14);
  Random random(15);
  BoneSpreads spreads(FourBones());
  for (int i = 0; i < 400; ++i) {
    spreads.Add(0, simulator.At(random.Normal(kLength, 0.02)));
    for (int bone = 1; bone < 4; ++bone)
      spreads.Add(bone, simulator.At(kLength));
  }
  // The standard error of the variance, 5 cm^2 in total times sqrt(3.34 / 400),
  // is 0.45 cm^2, or 1.1 mm at 2 cm. The tolerance is twice that, and as much
  // again for the shrinkage towards the other bones.
  EXPECT_NEAR(spreads.Estimate(0)->spread_m, 0.02, 0.004);
  // A rigid bone's variance of 1 cm^2 has a standard error of 0.09 cm^2; four
  // of these are (6 mm)^2.
  for (int bone = 1; bone < 4; ++bone) {
    EXPECT_LT(spreads.Estimate(bone)->spread_m, 0.006);
  }
}

// Bone ends located from their views alone.
class BoneEndsTest : public ::testing::Test {
 protected:
  BoneEndsTest() : cameras_(testing::RingOfCameras(5)) {
    problem_.times = {0};
    problem_.joints.resize(2);
  }

  void See(int joint, const Vector3d& truth, int views) {
    JointChain& chain = problem_.joints[joint];
    State state = State::Zero();
    state.head<3>() = truth + Vector3d(0.03, -0.02, 0.04);  // solver error
    chain.states = {state};
    for (int v = 0; v < views; ++v) {
      PixelMeasurement measurement;
      measurement.camera = &cameras_[v];
      measurement.px = *measurement.camera->Project(truth);
      measurement.sigma_px = 2.0;
      measurement.weight = 1.0;
      chain.measurements.push_back(measurement);
    }
    chain.first = {0, static_cast<int32_t>(chain.measurements.size())};
  }

  CameraRig cameras_;
  PersonProblem problem_;
};

TEST_F(BoneEndsTest, AreAtTriangulatedPositions) {
  const Vector3d a(0.2, 0.1, 1.0);
  const Vector3d b(0.1, 0.1, 0.6);
  See(0, a, 4);
  See(1, b, 2);
  const auto ends = LocateBoneEnds(problem_, 0, 0.25, 0.04);
  ASSERT_TRUE(ends[0].has_value());
  ASSERT_TRUE(ends[1].has_value());
  EXPECT_LT((ends[0]->position_m - a).norm(), 1e-6);
  EXPECT_LT((ends[1]->position_m - b).norm(), 1e-6);
  EXPECT_EQ(ends[0]->freedom, 5);
  EXPECT_EQ(ends[1]->freedom, 1);
  EXPECT_LT(ends[0]->square, 1e-6);
  EXPECT_LT(ends[0]->covariance_m2.trace(), ends[1]->covariance_m2.trace());
  EXPECT_GE(ends[0]->averaged_frames, 1.0);
  EXPECT_LE(ends[0]->averaged_frames, 25.0) << "at most a second";
  const auto observation = LookAtBone(*ends[0], *ends[1]);
  ASSERT_TRUE(observation.has_value());
  EXPECT_EQ(observation->freedom, 6);
  // Pixels are exact, but the noise assumed by the model would increase the
  // distance.
  EXPECT_NEAR(observation->distance_m, (a - b).norm(), 1e-6);
  EXPECT_GT(observation->added_m, 0.0);
  EXPECT_LT(observation->added_m, 0.001);
}

TEST_F(BoneEndsTest, UseTheTimeOfEachView) {
  const Vector3d position(0.2, 0.1, 1.0);
  const Vector3d velocity(2.0, -1.0, 0.5);
  for (const int joint : {0, 1}) See(joint, position, 4);
  JointChain& chain = problem_.joints[0];
  chain.states[0].tail<3>() = velocity;
  for (size_t v = 0; v < chain.measurements.size(); ++v) {
    PixelMeasurement& measurement = chain.measurements[v];
    measurement.offset_s = 0.01 * static_cast<double>(v);
    measurement.px = *measurement.camera->Project(
        position + measurement.offset_s * velocity);
  }
  const auto ends = LocateBoneEnds(problem_, 0, 0.25, 0.04);
  ASSERT_TRUE(ends[0].has_value());
  EXPECT_LT((ends[0]->position_m - position).norm(), 1e-6);
  EXPECT_LT(ends[0]->square, 1e-6);
}

TEST_F(BoneEndsTest, NeedTwoInlierViews) {
  See(0, Vector3d(0.2, 0.1, 1.0), 3);
  See(1, Vector3d(0.1, 0.1, 0.6), 1);
  problem_.joints[0].measurements[0].weight = 0.1;
  auto ends = LocateBoneEnds(problem_, 0, 0.25, 0.04);
  EXPECT_TRUE(ends[0].has_value());
  EXPECT_FALSE(ends[1].has_value());
  problem_.joints[0].measurements[1].gated = true;
  ends = LocateBoneEnds(problem_, 0, 0.25, 0.04);
  EXPECT_FALSE(ends[0].has_value());
}

}  // namespace
}  // namespace kinegraph
