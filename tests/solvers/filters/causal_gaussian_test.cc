#include "solvers/filters/causal_gaussian.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "tests/support/rig.h"
#include "tests/support/signals.h"

namespace kinegraph {
namespace {

using testing::FailedFrame;
using testing::FrameAt;

constexpr TimeNs kFrame = 40'000'000;  // 25 Hz

TEST(CausalGaussianWeightsTest, MatchScipy) {
  // The weights, newest first, with which
  // scipy.ndimage.gaussian_filter1d(mode='reflect') computes the last sample,
  // to four digits.
  const auto expect = [](double sigma, const std::vector<double>& expected) {
    const std::vector<double> weights = CausalGaussianWeights(sigma, 10);
    ASSERT_EQ(weights.size(), expected.size());
    for (size_t k = 0; k < expected.size(); ++k) {
      EXPECT_NEAR(weights[k], expected[k], 5e-5) << "sigma " << sigma;
    }
  };
  expect(0.3, {0.9962, 0.0038});
  expect(0.6, {0.8293, 0.1681, 0.0026});
  expect(0.8, {0.7270, 0.2502, 0.0224, 0.0004});
}

TEST(CausalGaussianWeightsTest, ShortListsAreReflectedAgain) {
  // A single pose has all the weight. With two poses a b, sigma 0.8 and radius
  // 3, places -2..4 of the reflected list are  b a | a b | b a a. The kernel is
  // centred on the newest pose, b at place 1: b lies at the offsets k = 0, +1
  // and -3, a at -1, -2, +2 and +3.
  ASSERT_EQ(CausalGaussianWeights(0.8, 1).size(), 1u);
  EXPECT_NEAR(CausalGaussianWeights(0.8, 1)[0], 1.0, 1e-15);
  const auto g = [](int k) { return std::exp(-k * k / (2 * 0.8 * 0.8)); };
  const double total = g(0) + 2 * (g(1) + g(2) + g(3));
  const std::vector<double> weights = CausalGaussianWeights(0.8, 2);
  ASSERT_EQ(weights.size(), 2u);
  EXPECT_NEAR(weights[0], (g(0) + g(1) + g(3)) / total, 1e-15);
  EXPECT_NEAR(weights[1], (g(1) + 2 * g(2) + g(3)) / total, 1e-15);
}

TEST(CausalGaussianWeightsTest, SumToOne) {
  for (const double sigma : {0.3, 0.6, 0.8, 2.0, 5.0}) {
    for (int length = 1; length < 15; ++length) {
      const auto weights = CausalGaussianWeights(sigma, length);
      EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1.0,
                  1e-14);
    }
  }
}

class CausalGaussianTest : public ::testing::Test {
 protected:
  std::unique_ptr<Estimator> Make(const CausalGaussianOptions& options) const {
    return MakeCausalGaussian(
        {testing::RingOfCameras(2), Coco17(), 25.0, KeptMatches::kNone},
        options);
  }

  static double PredictX(const Estimator& estimator, double frame, int joint) {
    Pose3d pose;
    estimator.Predict(static_cast<TimeNs>(frame * kFrame), &pose);
    return pose[joint].position_m.x();
  }
};

TEST_F(CausalGaussianTest, BirthIsNotSmoothedAndTheFilterIsRecursive) {
  CausalGaussianOptions options;
  options.sigma_frames = 0.6;
  const auto estimator = Make(options);
  estimator->Add(FrameAt(0, 0.0));
  EXPECT_EQ(estimator->Last()[0].position_m.x(), 0.0);
  estimator->Add(FrameAt(1, 1.0));
  const double w1 = CausalGaussianWeights(0.6, 2)[0];
  EXPECT_NEAR(estimator->Last()[0].position_m.x(), w1, 1e-15);
  estimator->Add(FrameAt(2, 1.0));
  const auto w = CausalGaussianWeights(0.6, 3);
  EXPECT_NEAR(estimator->Last()[0].position_m.x(), w[0] + w[1] * w1, 1e-15)
      << "the previous pose is the smoothed one";
}

TEST_F(CausalGaussianTest, WristsUseASeparateSigma) {
  const auto estimator = Make({});  // 0.3 and 0.8
  estimator->Add(FrameAt(0, 0.0));
  estimator->Add(FrameAt(1, 1.0));
  for (int j = 0; j < 17; ++j) {
    const double sigma = j == 9 || j == 10 ? 0.8 : 0.3;
    EXPECT_NEAR(estimator->Last()[j].position_m.x(),
                CausalGaussianWeights(sigma, 2)[0], 1e-15)
        << "joint " << j;
  }
}

TEST_F(CausalGaussianTest, VelocityIsTheMeanOfFiveDifferences) {
  CausalGaussianOptions options;
  options.smooth = false;
  const auto estimator = Make(options);
  // 0, 1, 4, 9, 16, 25, 36: the last five differences are 3, 5, 7, 9, 11.
  for (int f = 0; f < 7; ++f) estimator->Add(FrameAt(f, f * f));
  EXPECT_NEAR(PredictX(*estimator, 7, 0), 36.0 + 7.0, 1e-12);
  EXPECT_NEAR(PredictX(*estimator, 9, 0), 36.0 + 3 * 7.0, 1e-12);
}

TEST_F(CausalGaussianTest, ConstantVelocityAcrossAGap) {
  // 1 m per frame; two frames in between failed.
  for (const bool per_update : {false, true}) {
    CausalGaussianOptions options;
    options.smooth = false;
    options.velocity =
        per_update ? VelocityRule::kPerUpdate : VelocityRule::kOverTime;
    const auto estimator = Make(options);
    estimator->Add(FrameAt(0, 0.0));
    estimator->Add(FrameAt(1, 1.0));
    estimator->Add(FailedFrame(2));
    estimator->Add(FailedFrame(3));
    estimator->Add(FrameAt(4, 4.0));
    // Over time 4 m in 4 frames; per stored pose (1 + 3) / 2 = 2 m.
    EXPECT_NEAR(PredictX(*estimator, 5, 0), per_update ? 6.0 : 5.0, 1e-12);
  }
}

TEST_F(CausalGaussianTest, AFailedFrameIsNeitherStoredNorWritten) {
  const auto estimator = Make({});
  estimator->Add(FrameAt(0, 0.5));
  estimator->Add(FailedFrame(1));
  EXPECT_EQ(estimator->LastTime(), 0);
  std::vector<FinalPose> finals;
  estimator->ExtractFinals(&finals);
  ASSERT_EQ(finals.size(), 2u);
  EXPECT_EQ(finals[0].person.joints.size(), 17u);
  EXPECT_TRUE(finals[1].person.joints.empty());
  finals.clear();
  estimator->ExtractFinals(&finals);
  EXPECT_TRUE(finals.empty()) << "each final is given once";
}

TEST_F(CausalGaussianTest, EachUpdateDropsAtMostOneOldPose) {
  // Poses are stored at frames 0 to 3, 10 and 12. At frame 12, pose 0 is 12
  // frames old and is dropped; pose 1 is 11 frames old and stays this time. A
  // pose that is exactly ten frames old stays.
  CausalGaussianOptions options;
  options.sigma_frames = 5.0;  // reaches over the whole list
  options.wrist_sigma_frames = 5.0;
  const auto estimator = Make(options);
  std::vector<double> stored = {0.0};
  estimator->Add(FrameAt(0, 0.0));
  for (int f = 1; f < 4; ++f) {
    estimator->Add(FrameAt(f, 0.0));
    stored.push_back(0.0);
  }
  estimator->Add(FrameAt(10, 1.0));  // frame 0 is exactly ten old: five poses
  const double at_ten = estimator->Last()[0].position_m.x();
  EXPECT_NEAR(at_ten, CausalGaussianWeights(5.0, 5)[0], 1e-12);
  estimator->Add(FrameAt(12, 1.0));  // pose 0 is dropped: five poses again
  const auto w = CausalGaussianWeights(5.0, 5);
  EXPECT_NEAR(estimator->Last()[0].position_m.x(), w[0] + w[1] * at_ten, 1e-12);
}

TEST_F(CausalGaussianTest, AnUnseenJointKeepsItsVelocityThenFollowsTheBody) {
  CausalGaussianOptions options;
  options.smooth = false;
  options.hold_frames = 3.0;
  const auto estimator = Make(options);
  // The body moves 1 cm per frame; joint 9 moves 10 cm per frame, then is
  // unseen and follows the prediction.
  double wrist = 0.0;
  for (int f = 0; f < 6; ++f) {
    EstimatorFrame in = FrameAt(f, 0.01 * f);
    wrist = 0.1 * f;
    in.initial[9].position_m.x() = wrist;
    estimator->Add(in);
  }
  for (int f = 6; f < 20; ++f) {
    const double expected = f <= 8 ? wrist + 0.1 : wrist + 0.01;
    EXPECT_NEAR(PredictX(*estimator, f, 9), expected, 1e-12) << "frame " << f;
    Pose3d predicted;
    estimator->Predict(f * kFrame, &predicted);
    EXPECT_EQ(predicted[9].status, JointStatus::kInferred);
    EstimatorFrame in = FrameAt(f, 0.01 * f);
    in.initial[9] = predicted[9];
    in.triangulated[9] = 0;
    estimator->Add(in);
    wrist = expected;
  }
}

TEST_F(CausalGaussianTest, JointAppearingLaterUsesOnlyItsOwnHistory) {
  CausalGaussianOptions options;
  options.sigma_frames = 0.6;
  const auto estimator = Make(options);
  EstimatorFrame without = FrameAt(0, 0.0);
  without.initial[3].status = JointStatus::kMissing;
  without.triangulated[3] = 0;
  estimator->Add(without);
  EXPECT_FALSE(estimator->Last()[3].present());
  estimator->Add(FrameAt(1, 2.0));
  EXPECT_NEAR(estimator->Last()[3].position_m.x(), 2.0, 1e-15);
}

}  // namespace
}  // namespace kinegraph
