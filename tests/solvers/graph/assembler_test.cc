#include "solvers/graph/assembler.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "solvers/graph/outcome.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {
namespace {

TEST(PixelSigma, HandWorkedValues) {
  GraphOptions options;
  options.sigma_px[static_cast<int>(JointClass::kWrist)] = 8.0;
  const auto sigma = [&](JointClass joint, double confidence, double depth,
                         double focal) {
    return PixelSigma(options, joint, confidence, depth, focal);
  };
  EXPECT_DOUBLE_EQ(sigma(JointClass::kHip, 1.0, 4.0, 1000.0), 6.0);
  EXPECT_DOUBLE_EQ(sigma(JointClass::kWrist, 1.0, 4.0, 1000.0), 8.0);
  // A quarter of the confidence doubles sigma, twice the depth halves it, twice
  // the focal length doubles it.
  EXPECT_DOUBLE_EQ(sigma(JointClass::kHip, 0.25, 4.0, 1000.0), 12.0);
  EXPECT_DOUBLE_EQ(sigma(JointClass::kHip, 1.0, 8.0, 1000.0), 3.0);
  EXPECT_DOUBLE_EQ(sigma(JointClass::kHip, 1.0, 4.0, 2000.0), 12.0);
  // Sigmas are limited for confidences above 1 or near 0 and for distant
  // people.
  EXPECT_DOUBLE_EQ(sigma(JointClass::kHip, 7.0, 4.0, 1000.0), 6.0);
  EXPECT_DOUBLE_EQ(sigma(JointClass::kHip, 0.0, 4.0, 1000.0),
                   6.0 / std::sqrt(options.min_confidence));
  EXPECT_DOUBLE_EQ(sigma(JointClass::kHip, 1.0, 400.0, 1000.0),
                   options.min_sigma_px);
}

TEST(InformationScale, FollowsTheCorrelationOfErrors) {
  GraphOptions options;
  options.information_scale = 1.5;
  options.correlation_time_s = 0.1;
  const double rho = std::exp(-0.4);  // 25 Hz
  EXPECT_NEAR(InformationScale(options, 0.04), 1.5 * (1.0 - rho) / (1.0 + rho),
              1e-15);
  EXPECT_DOUBLE_EQ(InformationScale(options, INFINITY), 1.5);
  // The information per second hardly depends on the frame rate.
  EXPECT_NEAR(InformationScale(options, 1.0 / 60.0) * 60.0 /
                  (InformationScale(options, 1.0 / 120.0) * 120.0),
              1.0, 0.01);
  options.correlation_time_s = 0.0;
  EXPECT_DOUBLE_EQ(InformationScale(options, 0.04), 1.5);
}

TEST(NoiseScale, IsRecoveredDespiteOutliers) {
  Random random(71);
  for (const double scale : {0.5, 1.0, 2.0}) {
    std::vector<double> squares;
    for (int i = 0; i < 20000; ++i) {
      const double x = scale * random.Normal();
      const double y = scale * random.Normal();
      squares.push_back(random.Chance(0.1) ? 1e3 : x * x + y * y);
    }
    // 18000 values of relative spread 1 give a standard error of 0.4 % of the
    // scale. The tolerance is four standard errors.
    EXPECT_NEAR(EstimateNoiseScale(squares) / scale, 1.0, 0.016);
  }
  EXPECT_EQ(EstimateNoiseScale({}), 1.0);
  // A single residual carries little information.
  EXPECT_NEAR(EstimateNoiseScale({8.0}), 1.0, 0.1);
}

TEST(NoiseScale, CausalScaleForgetsOldResiduals) {
  Random random(72);
  CausalNoiseScale learnt;
  double applied = 1.0;
  for (const double scale : {2.0, 0.5}) {
    // 4000 of the 10000 residuals are kept, which gives a standard error of 0.8
    // % of the scale. The tolerance is a little more than four of them.
    for (int frame = 0; frame < 200; ++frame) {
      std::vector<double> squares;
      for (int i = 0; i < 50; ++i) {
        const double x = scale / applied * random.Normal();
        const double y = scale / applied * random.Normal();
        squares.push_back(x * x + y * y);
      }
      learnt.Add(squares, applied);
      applied = learnt.scale();
    }
    EXPECT_NEAR(learnt.scale() / scale, 1.0, 0.035);
  }
}

TEST(Schedule, StartsConvexAndEndsWithTheConfiguredLoss) {
  GraphOptions options;
  options.loss = LossKind::kTukey;
  options.loss_scale = 4.0;
  const SolveSchedule schedule = MakeSchedule(options);
  ASSERT_EQ(schedule.stages.size(), 3u);
  EXPECT_EQ(schedule.stages[0].loss, LossKind::kHuber);
  EXPECT_EQ(schedule.stages[1].loss, LossKind::kTukey);
  EXPECT_DOUBLE_EQ(schedule.stages[1].scale, 8.0);
  EXPECT_DOUBLE_EQ(schedule.stages[2].scale, 4.0);
  EXPECT_EQ(schedule.stages[2].max_iterations, options.max_iterations);
  options.loss = LossKind::kHuber;
  EXPECT_EQ(MakeSchedule(options).stages.size(), 1u);
}

TEST(CheckGraphOptions, RefusesATukeyLossThatRejectsEverything) {
  GraphOptions options;
  options.loss_scale = 0.02;
  EXPECT_NO_THROW(CheckGraphOptions(options));
  options.loss = LossKind::kTukey;
  EXPECT_THROW(CheckGraphOptions(options), OptionError);
  options.loss_scale = 0.1;
  EXPECT_NO_THROW(CheckGraphOptions(options));
}

TEST(StatusOf, DependsOnPresentPastAndNearSupport) {
  constexpr double kLimit_s = 0.5;
  struct Case {
    int inlier_views;
    bool ever_two_views;
    double nearest_support_s;
    JointStatus status;
  };
  for (const Case& one : {Case{2, true, 0.0, JointStatus::kObserved},
                          Case{1, true, 0.0, JointStatus::kInferred},
                          Case{0, true, 0.5, JointStatus::kInferred},
                          Case{0, true, 0.51, JointStatus::kMissing},
                          // One view alone never determined the distance.
                          Case{1, false, 0.0, JointStatus::kMissing},
                          Case{0, false, 0.1, JointStatus::kMissing}}) {
    EXPECT_EQ(StatusOf(one.inlier_views, one.ever_two_views,
                       one.nearest_support_s, kLimit_s),
              one.status)
        << one.inlier_views << " " << one.ever_two_views << " "
        << one.nearest_support_s;
  }
}

TEST(JointSupport, RemembersTheLastFrameWithAView) {
  JointSupport support;
  Extend(10, 0, &support);
  EXPECT_FALSE(support.by_one_view);
  Extend(20, 1, &support);
  EXPECT_TRUE(support.by_one_view);
  EXPECT_FALSE(support.by_two_views);
  Extend(30, 2, &support);
  Extend(40, 0, &support);
  EXPECT_TRUE(support.by_two_views);
  EXPECT_EQ(support.last_time, 30);
}

// A trunk and a leg of 0.4 m bones, upright, each joint with a sigma of 1 cm.
struct TrunkAndLeg {
  enum Joint { kNeck, kHip, kKnee, kAnkle, kCount };

  const std::vector<KnownBone> bones = {
      {{kNeck, kHip}, 0.4}, {{kHip, kKnee}, 0.4}, {{kKnee, kAnkle}, 0.4}};
  PersonPose pose;

  TrunkAndLeg() {
    for (int j = 0; j < kCount; ++j) {
      pose.joints.push_back({{0.0, 0.0, -0.4 * j}, JointStatus::kInferred});
      pose.covariances.push_back(
          Eigen::Matrix3d(1e-4 * Eigen::Matrix3d::Identity()));
    }
  }
  void MakeUnsure(int joint, double sigma_m) {
    // Along one axis only, as for depth.
    (*pose.covariances[joint])(1, 1) = sigma_m * sigma_m;
  }
  void Move(int joint, double by_m) {
    pose.joints[joint].position_m.y() += by_m;
  }
  std::vector<int> Missing() {
    DropUnsureJoints(bones, &pose);
    std::vector<int> missing;
    for (int j = 0; j < kCount; ++j) {
      if (!pose.joints[j].present()) missing.push_back(j);
      EXPECT_EQ(pose.joints[j].present(), pose.covariances[j].has_value());
    }
    return missing;
  }
};

TEST(DropUnsureJoints, DropsALegFarFromItsHip) {
  TrunkAndLeg body;
  for (const int j : {body.kKnee, body.kAnkle}) {
    body.MakeUnsure(j, 3.0);
    body.Move(j, 3.0);
  }
  EXPECT_EQ(body.Missing(), (std::vector<int>{body.kKnee, body.kAnkle}));
}

TEST(DropUnsureJoints, DropsDerivativesWithTheirJoint) {
  TrunkAndLeg body;
  body.pose.derivatives.assign(body.kCount, JointDerivatives());
  body.MakeUnsure(body.kAnkle, 3.0);
  body.Move(body.kAnkle, 3.0);
  EXPECT_EQ(body.Missing(), std::vector<int>{body.kAnkle});
  EXPECT_FALSE(body.pose.derivatives[body.kAnkle].has_value());
  EXPECT_TRUE(body.pose.derivatives[body.kKnee].has_value());
}

TEST(DropUnsureJoints, KeepsJointsWhoseBonesHaveTheKnownLength) {
  TrunkAndLeg body;
  body.MakeUnsure(body.kKnee, 3.0);
  body.MakeUnsure(body.kAnkle, 3.0);
  EXPECT_TRUE(body.Missing().empty());
}

TEST(DropUnsureJoints, LimitIsHalfTheBone) {
  for (const double sigma_m : {0.19, 0.21}) {
    TrunkAndLeg body;
    body.MakeUnsure(body.kAnkle, sigma_m);
    body.Move(body.kAnkle, 1.0);
    EXPECT_EQ(body.Missing().empty(), sigma_m < 0.2) << sigma_m;
  }
}

TEST(DropUnsureJoints, KeepsAWholeBodyOfUncertainDepth) {
  TrunkAndLeg body;
  for (int j = 0; j < body.kCount; ++j) body.MakeUnsure(j, 1.0);
  EXPECT_TRUE(body.Missing().empty());
}

// Joints without a bone of known length are judged by the body's longest bone.
TEST(DropUnsureJoints, UsesTheLongestBoneWhereABoneIsUnmeasured) {
  TrunkAndLeg body;
  body.MakeUnsure(body.kAnkle, 3.0);
  body.Move(body.kAnkle, 3.0);
  DropUnsureJoints({body.bones[0], body.bones[1]}, &body.pose);
  EXPECT_FALSE(body.pose.joints[body.kAnkle].present());
  EXPECT_TRUE(body.pose.joints[body.kKnee].present());
}

TEST(DropUnsureJoints, KeepsJointsWithoutBonesOrCovariances) {
  TrunkAndLeg body;
  body.MakeUnsure(body.kAnkle, 3.0);
  body.Move(body.kAnkle, 3.0);
  DropUnsureJoints({}, &body.pose);
  EXPECT_TRUE(body.pose.joints[body.kAnkle].present());
  body.pose.covariances.clear();
  DropUnsureJoints(body.bones, &body.pose);
  EXPECT_TRUE(body.pose.joints[body.kAnkle].present());
}

}  // namespace
}  // namespace kinegraph
