#include "solvers/noise/motion_level.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

constexpr TimeNs kFrame = 40'000'000;
constexpr double kSigmaM = 0.005;

// Shows a bank 100 frames of a joint that swings, from `begin` on.
void ShowSwing(TimeNs begin, FilterBank* bank, Levels* evidence) {
  for (int k = 0; k < 100; ++k) {
    FramePoint point;
    point.position_m = {0.3 * std::sin(0.2 * k), 0.01 * k, 1.0};
    point.covariance_m2 = kSigmaM * kSigmaM * Eigen::Matrix3d::Identity();
    bank->Add(begin + k * kFrame, point, ErrorCorrelation(), evidence);
  }
}

class FilterBankPauses : public ::testing::TestWithParam<double> {};

// After a minute even the least driven level has lost the joint by metres.
// Between the evidence of a pause and that of two recordings stands the first
// point after it alone, which tells of the levels what the ways of years would.
TEST_P(FilterBankPauses, KeepTheirDigits) {
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
    // The one point is less likely by the spread of where it may be: no more
    // than the log of q dt^3 / 3 for each axis, and for a restart nothing.
    const double spread =
        usual * std::exp(LogLevel(level)) * std::pow(GetParam() + 1.0, 3.0);
    const double bound = 1.5 * std::log1p(spread / (kSigmaM * kSigmaM)) + 10.0;
    EXPECT_NEAR(whole[level], parts[level], bound) << "level " << level;
  }
  // The level that the motion tells stays the one.
  EXPECT_EQ(std::max_element(whole.begin(), whole.end()) - whole.begin(),
            std::max_element(parts.begin(), parts.end()) - parts.begin());
}
INSTANTIATE_TEST_SUITE_P(All, FilterBankPauses,
                         ::testing::Values(60.0, 3600.0, 14400.0, 86400.0,
                                           3.15e7));

}  // namespace
}  // namespace kinegraph
