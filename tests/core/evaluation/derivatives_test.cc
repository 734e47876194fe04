#include "core/evaluation/derivatives.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

using Eigen::Vector3d;

constexpr double kRate_hz = 100.0;

// A standing person whose joints all move by `path`, for `count` frames.
TrackSequence Moving(int count, const std::function<Vector3d(double)>& path) {
  std::vector<TrackFrame> frames;
  for (int k = 0; k < count; ++k) {
    Pose3d pose = StandingTum14();
    for (Joint3d& joint : pose) joint.position_m += path(k / kRate_hz);
    frames.push_back(Frame(k, {Person(0, pose)}));
  }
  return Tracks(frames);
}

DerivativeOptions Options() {
  DerivativeOptions options;
  options.rate_hz = kRate_hz;
  return options;
}

TEST(DerivativesTest, ParabolaErrorsMatchHandComputedValues) {
  // A parabola of another curvature: its velocity error grows as 0.4 t, its
  // acceleration error is 0.4 everywhere, both exact for central differences.
  const auto truth = Moving(
      101, [](double t) { return Vector3d(0.5 * t + 0.5 * t * t, 0.0, 0.0); });
  const auto found = Moving(
      101, [](double t) { return Vector3d(0.5 * t + 0.7 * t * t, 0.0, 0.0); });
  const DerivativeResult result = EvaluateDerivatives(truth, found, Options());
  double squares = 0.0;
  for (int k = 1; k < 100; ++k) squares += std::pow(0.4 * k / kRate_hz, 2);
  const DerivativeErrors& all = result.all[0];
  EXPECT_EQ(all.count, 99 * 14);
  EXPECT_NEAR(all.velocity_rms_m_s, std::sqrt(squares / 99.0), 1e-9);
  EXPECT_NEAR(all.speed_bias_m_s, 0.4 * 0.5, 1e-9);
  EXPECT_NEAR(all.acceleration_rms_m_s2, 0.4, 1e-9);
  EXPECT_NEAR(all.acceleration_bias_m_s2, 0.4, 1e-9);
  EXPECT_NEAR(result.by_joint[0][3].acceleration_rms_m_s2, 0.4, 1e-9);
  // No peaks and no contacts.
  EXPECT_EQ(all.peaks, 0);
  EXPECT_EQ(result.contacts, 0);
  EXPECT_EQ(result.all[1].count, 0);
  EXPECT_TRUE(std::isnan(result.all[1].velocity_rms_m_s));
}

// Velocities and accelerations stored in the tracks are scored where present.
TEST(DerivativesTest, DerivativesOfTheModelTakePrecedence) {
  const auto path = [](double t) { return Vector3d(0.5 * t * t, 0.0, 0.0); };
  const auto truth = Moving(101, path);
  auto found = truth;
  const auto own = [&found](double faster_m_s,
                            std::optional<double> more_m_s2) {
    for (TrackFrame& frame : found.frames) {
      JointDerivatives derivatives;
      derivatives.velocity_m_s = {
          static_cast<double>(frame.frame) / kRate_hz + faster_m_s, 0.0, 0.0};
      if (more_m_s2) {
        derivatives.acceleration_m_s2 = Vector3d(1.0 + *more_m_s2, 0.0, 0.0);
      }
      frame.people[0].derivatives.assign(frame.people[0].joints.size(),
                                         derivatives);
    }
  };
  DerivativeResult result = EvaluateDerivatives(truth, found, Options());
  EXPECT_EQ(result.velocity_source, DerivativeSource::kDifferences);
  EXPECT_NEAR(result.all[0].velocity_rms_m_s, 0.0, 1e-9);
  own(0.3, std::nullopt);
  result = EvaluateDerivatives(truth, found, Options());
  EXPECT_EQ(result.velocity_source, DerivativeSource::kModel);
  EXPECT_EQ(result.acceleration_source, DerivativeSource::kModelVelocity);
  EXPECT_NEAR(result.all[0].velocity_rms_m_s, 0.3, 1e-9);
  EXPECT_NEAR(result.all[0].acceleration_rms_m_s2, 0.0, 1e-9);
  // A velocity that grows by 1.5 m/s^2 instead of 1.
  for (TrackFrame& frame : found.frames) {
    for (auto& derivatives : frame.people[0].derivatives) {
      derivatives->velocity_m_s.x() *= 1.5;
    }
  }
  EXPECT_NEAR(
      EvaluateDerivatives(truth, found, Options()).all[0].acceleration_rms_m_s2,
      0.5, 1e-9);
  own(0.3, 0.7);
  result = EvaluateDerivatives(truth, found, Options());
  EXPECT_EQ(result.acceleration_source, DerivativeSource::kModel);
  EXPECT_NEAR(result.all[0].acceleration_rms_m_s2, 0.7, 1e-9);
  // As with differences, only frames with two neighbours are scored.
  EXPECT_EQ(result.all[0].count, 99 * 14);
}

// A ground truth with every other frame is compared with differences over two
// frames of the tracks.
TEST(DerivativesTest, TruthMayHaveHalfTheRate) {
  const auto parabola = [](double a) {
    return [a](double t) { return Vector3d(a * t * t, 0.0, 0.0); };
  };
  const TrackSequence truth = Moving(101, parabola(0.5));
  TrackSequence half = truth;
  half.frames.clear();
  for (size_t k = 0; k < truth.frames.size(); k += 2) {
    half.frames.push_back(truth.frames[k]);
  }
  const DerivativeResult result =
      EvaluateDerivatives(half, Moving(101, parabola(0.7)), Options());
  EXPECT_EQ(result.all[0].count, 49 * 14);
  EXPECT_NEAR(result.all[0].acceleration_rms_m_s2, 0.4, 1e-9);
}

// A fall at 3 m/s until `at_s`, then rest; the transition is smoothed over
// `round_s`.
Vector3d Landing(double t, double at_s, double round_s) {
  const double before = t - at_s;
  const double smooth =
      0.5 * (before + std::sqrt(before * before + round_s * round_s));
  return {0.0, 0.0, -3.0 * (before - smooth)};
}

TEST(DerivativesTest, ASmoothedLandingLosesItsPeak) {
  // The second derivative of the rounded path is 3 r^2 / (2 (t^2 + r^2)^1.5):
  // 1.5 / r at its peak, so a radius of 0.04 s instead of 0.01 s gives a
  // quarter of it.
  const auto truth =
      Moving(200, [](double t) { return Landing(t, 1.0, 0.01); });
  const auto found =
      Moving(200, [](double t) { return Landing(t, 1.03, 0.04); });
  const DerivativeResult result = EvaluateDerivatives(truth, found, Options());
  EXPECT_EQ(result.contacts, 2);  // both ankles
  const DerivativeErrors& contacts = result.all[1];
  EXPECT_EQ(contacts.count, 21 * 14);  // 0.1 s on either side
  EXPECT_EQ(contacts.peaks, 14);
  EXPECT_NEAR(contacts.peak_instant_ms, 30.0, 1e-9);
  // The second difference of the path's values at -0.01, 0 and 0.01 s lowers
  // the sharp peak to 2 (sqrt(2) - 1) of its value.
  const double seen = 2.0 * (std::sqrt(2.0) - 1.0);
  const double smoothed = 2.0 * 16.0 * (std::sqrt(1.0 + 1.0 / 16.0) - 1.0);
  EXPECT_NEAR(contacts.peak_error_percent,
              100.0 * (0.25 * smoothed / seen - 1.0), 1e-6);
  EXPECT_LT(contacts.acceleration_bias_m_s2, 0.0);
}

TEST(DerivativesTest, NoDerivativesAcrossGapsOrIdentities) {
  auto truth = Moving(20, [](double t) { return Vector3d(t, 0.0, 0.0); });
  auto found = truth;
  found.frames.erase(found.frames.begin() + 10);
  const DerivativeResult result = EvaluateDerivatives(truth, found, Options());
  EXPECT_EQ(result.all[0].count, (18 - 3) * 14);
  // Another identity counts as another person.
  found = truth;
  for (int k = 10; k < 20; ++k) found.frames[k].people[0].id = TrackId(7);
  EXPECT_EQ(EvaluateDerivatives(truth, found, Options()).all[0].count,
            (18 - 2) * 14);
}

}  // namespace
}  // namespace kinegraph::testing
