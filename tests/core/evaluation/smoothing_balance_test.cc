#include "core/evaluation/smoothing_balance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/base/constants.h"
#include "core/base/random.h"

namespace kinegraph {
namespace {

constexpr double kRateHz = 50.0;
constexpr int kFrames = 2000;  // 79 segments
constexpr double kAmplitudeM = 0.1;
constexpr double kNoiseM = 0.02;  // of the triangulation, per axis

// A 4 Hz motion along x, at the centre of a spectral bin.
Eigen::Vector3d MotionAt(double frame) {
  return {kAmplitudeM * std::sin(2.0 * kPi * 4.0 * frame / kRateHz), 0.0, 0.0};
}

JointTraces TraceOf(const std::function<Eigen::Vector3d(int)>& point_at) {
  JointTraces traces;
  JointTrace& trace = traces[{TrackId(7), 3}];
  for (int i = 0; i < kFrames; ++i) trace.points.push_back(point_at(i));
  return traces;
}

Eigen::Vector3d Noise(Random* random, double sigma_m) {
  return {random->Normal(0.0, sigma_m), random->Normal(0.0, sigma_m),
          random->Normal(0.0, sigma_m)};
}

class SmoothingBalanceTest : public ::testing::Test {
 protected:
  SmoothingBalanceTest() {
    Random random(1);
    reference_ = TraceOf([&](int i) -> Eigen::Vector3d {
      return MotionAt(i) + Noise(&random, 2.0 * kNoiseM);
    });
    raw_ = TraceOf([&](int i) -> Eigen::Vector3d {
      return MotionAt(i) + Noise(&random, kNoiseM);
    });
  }

  SmoothingBalance Of(const JointTraces& smoothed) const {
    SmoothingSpectra spectra(kRateHz);
    spectra.Add(reference_, raw_, smoothed, std::nullopt);
    return spectra.OfJoint(3);
  }

  JointTraces reference_, raw_;
};

// Root mean square of the sine.
const double kMotionM = kAmplitudeM / std::sqrt(2.0);
// The trend and the mean take 2 of 50 degrees of freedom from the noise.
const double kKeptM = kNoiseM * std::sqrt(3.0 * 48.0 / 50.0);
// The standard error of a power from 79 segments of 48 x 3 noise values, half
// overlapping, is 2 %; that of the cross-spectrum with the reference's errors,
// whose power is four times as large, is 4 %. An amplitude, the root of a
// power, has half of this relative error: 10 % are 5 standard errors.
constexpr double kTolerance = 0.1;

TEST_F(SmoothingBalanceTest, AScaledDownMotionCountsAsRemoved) {
  const SmoothingBalance balance =
      Of(TraceOf([](int i) -> Eigen::Vector3d { return 0.4 * MotionAt(i); }));
  EXPECT_NEAR(balance.removed_m, 0.6 * kMotionM, kTolerance * kMotionM);
  EXPECT_NEAR(balance.error_m, 0.6 * kMotionM, kTolerance * kMotionM);
  EXPECT_EQ(balance.excess, SmoothingBalance::Excess::kMotionRemoved);
  EXPECT_TRUE(balance.is_excessive);
}

TEST_F(SmoothingBalanceTest, ADelayCountsAsRemovedMotion) {
  // |1 - exp(i phi)| = 2 sin(phi / 2), phi = 2 pi 4 Hz 0.06 s.
  const SmoothingBalance balance =
      Of(TraceOf([](int i) { return MotionAt(i - 3); }));
  EXPECT_NEAR(balance.removed_m, 2.0 * std::sin(kPi * 0.24) * kMotionM,
              2.0 * kTolerance * kMotionM);
  EXPECT_EQ(balance.excess, SmoothingBalance::Excess::kMotionRemoved);
  EXPECT_TRUE(balance.is_excessive);
}

TEST_F(SmoothingBalanceTest, RawTriangulationKeepsNoise) {
  const SmoothingBalance balance = Of(raw_);
  EXPECT_NEAR(balance.kept_m, kKeptM, kTolerance * kKeptM);
  EXPECT_LT(balance.removed_m, kTolerance * kMotionM);
  EXPECT_LT(balance.attainable_m, 0.75 * kKeptM);
  EXPECT_EQ(balance.excess, SmoothingBalance::Excess::kNoiseKept);
  EXPECT_TRUE(balance.is_excessive);
}

TEST_F(SmoothingBalanceTest, NoiseFreeMotionHasNoError) {
  const SmoothingBalance balance = Of(TraceOf(MotionAt));
  EXPECT_LT(balance.error_m, kTolerance * kMotionM);
  EXPECT_FALSE(balance.is_excessive);
}

TEST_F(SmoothingBalanceTest, ShortGapsAreFilledAndLongGapsExcluded) {
  const auto with_gap = [&](int frames) {
    JointTraces smoothed = raw_;
    for (int i = 510; i < 510 + frames; ++i) {
      smoothed.begin()->second.points[i].setConstant(
          std::numeric_limits<double>::quiet_NaN());
    }
    return Of(smoothed).segments;
  };
  const int64_t all = Of(raw_).segments;
  EXPECT_EQ(all, 79);
  EXPECT_EQ(with_gap(5), all);      // 0.1 s
  EXPECT_EQ(with_gap(6), all - 2);  // both segments with these frames
}

TEST_F(SmoothingBalanceTest, ImageTracesAreScaledByDepth) {
  constexpr double kMetresPerPx = 0.004;
  const auto in_image = [&](const JointTraces& traces) {
    JointTraces image = traces;
    for (Eigen::Vector3d& point : image.begin()->second.points) {
      point = {point.x() / kMetresPerPx, point.y() / kMetresPerPx,
               kMetresPerPx};
    }
    return image;
  };
  SmoothingSpectra spectra(kRateHz);
  SmoothingSpectra other(kRateHz);
  spectra.Add(in_image(reference_), in_image(raw_), in_image(raw_), 0);
  other.Add(in_image(reference_), in_image(raw_), in_image(raw_), 1);
  spectra.Merge(other);
  const SmoothingBalance balance = spectra.OfJoint(3);
  EXPECT_EQ(balance.segments, 2 * 79);
  const double kept_m = kKeptM * std::sqrt(2.0 / 3.0);  // of two axes
  EXPECT_NEAR(balance.kept_m, kept_m, kTolerance * kept_m);
}

TEST(SmoothingBalance, ThreeSegmentsAreTooFew) {
  SmoothingSpectra spectra(kRateHz);
  JointTraces traces = TraceOf(MotionAt);
  traces.begin()->second.points.resize(100);
  spectra.Add(traces, traces, traces, std::nullopt);
  const SmoothingBalance balance = spectra.OfJoint(3);
  EXPECT_EQ(balance.segments, 3);
  EXPECT_TRUE(std::isnan(balance.error_m));
  EXPECT_TRUE(std::isnan(PooledBalance({balance}).error_m));
}

}  // namespace
}  // namespace kinegraph
