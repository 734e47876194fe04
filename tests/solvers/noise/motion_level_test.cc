#include "solvers/noise/motion_level.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {
namespace {

constexpr double kUsual = 2.0;    // m^2/s^3
constexpr double kSigma = 0.005;  // m

// The evidence in every frame of a simulated joint whose process noise is
// kUsual times `level(t)`.
template <typename LevelAt>
std::vector<Levels> Simulate(double rate_hz, double seconds,
                             const LevelAt& level, uint64_t seed,
                             std::vector<TimeNs>* times) {
  Random random(seed);
  const auto normal = [&] {
    return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
  };
  FilterBank bank(kUsual);
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  std::vector<Levels> evidence;
  const double dt = 1.0 / rate_hz;
  for (int k = 0; k < static_cast<int>(seconds * rate_hz); ++k) {
    const double t = k * dt;
    // L = sqrt(q dt) [dt / sqrt 3, 0; sqrt 3 / 2, 1 / 2] for each axis.
    const double root = std::sqrt(kUsual * level(t) * dt);
    const Eigen::Vector3d a = root * normal();
    const Eigen::Vector3d b = root * normal();
    p += dt * v + dt / std::sqrt(3.0) * a;
    v += 0.5 * std::sqrt(3.0) * a + 0.5 * b;
    FramePoint point;
    point.position_m = p + kSigma * normal();
    point.covariance_m2 = kSigma * kSigma * Eigen::Matrix3d::Identity();
    times->push_back(FromSeconds(t));
    Levels frame{};
    bank.Add(times->back(), point, {0.0, 0.1}, &frame);
    evidence.push_back(frame);
  }
  return evidence;
}

Levels Sum(const std::vector<Levels>& evidence) {
  Levels sum{};
  for (const Levels& frame : evidence) {
    for (int i = 0; i < kLevelCount; ++i) sum[i] += frame[i];
  }
  return sum;
}

TEST(MotionLevelTest, LikelihoodRecoversTheProcessNoise) {
  // The smoother's bandwidth is (q / (R h))^(1/4), with the frame interval h:
  // 29 to 130 rad/s, which gives about 190 to 830 independent values in 20 s on
  // each of three axes, so ln q is accurate to about 0.1. The parabola over
  // levels that are ln 3.2 apart adds as much. The tolerance is three times the
  // sum.
  for (const double rate_hz : {30.0, 120.0}) {
    for (const double level : {0.3, 1.0, 30.0}) {
      std::vector<TimeNs> times;
      const Levels sum = Sum(Simulate(
          rate_hz, 20.0, [&](double) { return level; }, 7, &times));
      EXPECT_NEAR(RecordingLevel(sum), std::log(level), 0.6)
          << rate_hz << " Hz, level " << level;
    }
  }
}

TEST(MotionLevelTest, DefaultLevelWithoutEvidence) {
  EXPECT_NEAR(RecordingLevel(Levels{}), 0.0, 0.01);
}

TEST(MotionLevelTest, LocatesABurst) {
  for (const double rate_hz : {30.0, 120.0}) {
    std::vector<TimeNs> times;
    const std::vector<Levels> evidence = Simulate(
        rate_hz, 8.0, [](double t) { return t > 4.0 && t < 4.5 ? 300.0 : 0.1; },
        8, &times);
    LevelChain chain(RecordingLevel(Sum(evidence)));
    std::vector<LevelChain::Vector> seen;
    for (const Levels& frame : evidence) seen.push_back(Likelihood(frame));
    const std::vector<double> levels =
        SmoothLevels(chain.stationary(), times, seen, &chain);
    // The burst is three thousand times stronger than the rest. Until half a
    // second before it, the level stays below twice the usual power. Afterwards
    // it may remain high, because the stiff filters lose the joint in the burst
    // and recover slowly.
    for (size_t k = 0; k < levels.size(); ++k) {
      const double t = ToSeconds(times[k]);
      if (t > 4.1 && t < 4.4) {
        EXPECT_GT(levels[k], std::log(20.0)) << t;
      }
      if (t > 1.0 && t < 3.5) {
        EXPECT_LT(levels[k], std::log(2.0)) << t;
      }
      // From one second after the burst on, the level is below the minimum
      // required in the burst.
      if (t > 5.5) {
        EXPECT_LT(levels[k], std::log(20.0)) << t;
      }
    }
  }
}

TEST(LevelChainTest, IsConsistentAcrossFrameRates) {
  LevelChain chain(0.7);
  const LevelChain::Matrix step = chain.Transition(FromSeconds(0.004));
  LevelChain::Matrix many = LevelChain::Matrix::Identity();
  for (int i = 0; i < 10; ++i) many = (step * many).eval();
  // Rounding errors of ten products of entries below 1.
  EXPECT_LT((many - chain.Transition(FromSeconds(0.04))).cwiseAbs().maxCoeff(),
            1e-12);
  for (int i = 0; i < kLevelCount; ++i) {
    EXPECT_NEAR(step.col(i).sum(), 1.0, 1e-12);
    EXPECT_GE(step.col(i).minCoeff(), 0.0);
  }
}

TEST(LevelChainTest, StaysNearTheRecordingLevel) {
  LevelChain::Vector log_levels;
  for (int i = 0; i < kLevelCount; ++i) log_levels[i] = LogLevel(i);
  for (const double level : {0.0, 1.5}) {
    LevelChain chain(level);
    // A normal distribution of spread 1 on a grid of step 1.2 from -3.7 to 6.9:
    // the step changes the mean by 2 (2 pi / 1.2) exp(-2 (pi / 1.2)^2) = 1e-5
    // (Poisson's summation), the ends by about the density half a step beyond
    // -3.7, 4e-5.
    EXPECT_NEAR(chain.stationary().dot(log_levels), level, 1e-4);
    // Jumps to any level (0.2 per second) draw the mean level towards the
    // middle of the grid, but the return to the recording's level (rate 1 / 0.5
    // s) is ten times as fast: a tenth of the distance.
    const LevelChain::Vector later =
        chain.Transition(FromSeconds(20.0)) * chain.stationary();
    EXPECT_NEAR(later.dot(log_levels), level,
                0.2 * 0.5 * (log_levels.mean() - level));
  }
}

constexpr TimeNs kFrame = 40'000'000;
constexpr double kSigmaM = 0.005;

// Passes 100 frames of an oscillating joint to a bank, from `begin` on.
void ShowSwing(TimeNs begin, FilterBank* bank, Levels* evidence) {
  for (int k = 0; k < 100; ++k) {
    FramePoint point;
    point.position_m = {0.3 * std::sin(0.2 * k), 0.01 * k, 1.0};
    point.covariance_m2 = kSigmaM * kSigmaM * Eigen::Matrix3d::Identity();
    bank->Add(begin + k * kFrame, point, ErrorCorrelation(), evidence);
  }
}

class FilterBankPauses : public ::testing::TestWithParam<double> {};

// After a minute even the filter with the least process noise has an
// uncertainty of tens of metres. The evidence of a recording with a pause
// differs from that of two separate recordings only in the first point after
// the pause, which must not dominate the levels.
TEST_P(FilterBankPauses, DoNotDegradeTheLikelihoods) {
  const double usual = UsualProcessNoise(JointClass::kWrist);
  Levels whole{};
  FilterBank bank(usual);
  ShowSwing(0, &bank, &whole);
  ShowSwing(100 * kFrame + FromSeconds(GetParam()), &bank, &whole);
  Levels parts{};
  for (const TimeNs begin : {TimeNs{0}, 1000 * kFrame}) {
    FilterBank alone(usual);
    ShowSwing(begin, &alone, &parts);
  }
  for (int level = 0; level < kLevelCount; ++level) {
    ASSERT_TRUE(std::isfinite(whole[level])) << "level " << level;
    // The spread of the prediction, with a variance below q (pause + 1 s)^3,
    // reduces the log-likelihood of the first point after the pause by half the
    // logarithm of this variance over the noise's on each axis.
    const double spread =
        usual * std::exp(LogLevel(level)) * std::pow(GetParam() + 1.0, 3.0);
    const double bound = 1.5 * std::log1p(spread / (kSigmaM * kSigmaM)) + 10.0;
    EXPECT_NEAR(whole[level], parts[level], bound) << "level " << level;
  }
  // The level determined by the motion is unchanged.
  EXPECT_EQ(std::max_element(whole.begin(), whole.end()) - whole.begin(),
            std::max_element(parts.begin(), parts.end()) - parts.begin());
}
INSTANTIATE_TEST_SUITE_P(All, FilterBankPauses,
                         ::testing::Values(60.0, 3600.0, 14400.0, 86400.0,
                                           3.15e7));

TEST(MotionGroupsTest, LimbsAreGroupedBySideAndTrunkByClass) {
  const Skeleton& body = Halpe26();
  const MotionGroups groups(body);
  const auto group = [&](const std::string& joint) {
    return groups.of_joint(body.IndexOf(joint));
  };
  for (const std::string joint : {"elbow", "wrist", "knee", "ankle", "heel"}) {
    EXPECT_NE(group("l_" + joint), group("r_" + joint)) << joint;
  }
  EXPECT_EQ(group("l_heel"), group("l_big_toe"));
  EXPECT_NE(group("l_elbow"), group("l_wrist"));
  EXPECT_EQ(group("l_hip"), group("r_hip"));
  EXPECT_EQ(group("l_ear"), group("nose"));
  EXPECT_EQ(group("neck"), group("mid_hip"));
  // Head, trunk, shoulder, hip; elbow, wrist, knee, ankle and foot on each
  // side.
  ASSERT_EQ(groups.size(), 4 + 5 * 2);
  double sum = 0.0;
  for (int g = 0; g < groups.size(); ++g) sum += groups.share_of_class(g);
  EXPECT_DOUBLE_EQ(sum, 9.0) << "shares of a class sum to one";
}

}  // namespace
}  // namespace kinegraph
