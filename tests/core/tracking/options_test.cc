#include "core/tracking/options.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/rig.h"

namespace kinegraph {
namespace {

// Four cameras, each `radius_m` from the point at which all look.
CameraRig Circle(double radius_m, double focal_px) {
  CameraRig cameras;
  for (const Camera& camera :
       testing::RingOfCameras(4, std::sqrt(radius_m * radius_m - 1.0))) {
    CameraParameters parameters = camera.parameters();
    parameters.K(0, 0) = parameters.K(1, 1) = focal_px;
    cameras.emplace_back(parameters);
  }
  return cameras;
}

TEST(Gates, WorkingDistanceIsWhereTheAxesMeet) {
  EXPECT_NEAR(WorkingDistance(Circle(6.0, 1000.0)), 6.0, 1e-9);
  // A single axis, or parallel axes, give the default distance.
  CameraRig cameras = {Circle(6.0, 1000.0)[0]};
  EXPECT_EQ(WorkingDistance(cameras), 4.0);
  CameraParameters beside = cameras[0].parameters();
  beside.t.x() += 0.5;
  cameras.emplace_back(beside);
  EXPECT_EQ(WorkingDistance(cameras), 4.0);
}

TEST(Gates, PixelGatesEqualThePaperByDefault) {
  const TrackerOptions options;
  const TrackerOptions same =
      WithScaledGates(options, Circle(3.0, 2000.0), 120.0);
  EXPECT_EQ(same.association.alpha_2d_px_per_frame, 70.0);
  EXPECT_EQ(same.reconstruction.alpha_epi_px, 60.0);
  EXPECT_EQ(same.reconstruction.tau_frames, 3.0);
}

// Hand-computed values for 1000 px at 5 m, 200 px/m, and 50 Hz.
TEST(Gates, MetresAndSecondsBecomePixelsAndFrames) {
  TrackerOptions options;
  options.gates.units = GateUnits::kMetres;
  const TrackerOptions scaled =
      WithScaledGates(options, Circle(5.0, 1000.0), 50.0);
  EXPECT_NEAR(scaled.reconstruction.alpha_epi_px, 200 * 0.19 + 6, 1e-9);
  EXPECT_EQ(scaled.initialisation.alpha_group_px,
            scaled.reconstruction.alpha_epi_px);
  EXPECT_EQ(scaled.initialisation.alpha_filter_px,
            scaled.reconstruction.alpha_epi_px);
  EXPECT_NEAR(scaled.association.alpha_2d_px_per_frame,
              200 * (0.12 + 2.6 / 50) + 15, 1e-9);
  EXPECT_NEAR(scaled.association.lambda_a_per_frame, 1.5, 1e-12);
  EXPECT_NEAR(scaled.reconstruction.lambda_t_per_frame, 2.5, 1e-12);
  EXPECT_NEAR(scaled.reconstruction.tau_frames, 6.0, 1e-12);
}

// Without a detector error (detector_px), gates in pixels are proportional to
// the size of a person's image.
TEST(Gates, GrowWithFocalLengthAndShrinkWithDistance) {
  TrackerOptions options;
  options.gates.units = GateUnits::kMetres;
  options.gates.detector_px = 0.0;
  const auto epipolar = [&](double radius_m, double focal_px) {
    return WithScaledGates(options, Circle(radius_m, focal_px), 25.0)
        .reconstruction.alpha_epi_px;
  };
  EXPECT_NEAR(epipolar(5.0, 2000.0), 2.0 * epipolar(5.0, 1000.0), 1e-9);
  EXPECT_NEAR(epipolar(10.0, 1000.0), 0.5 * epipolar(5.0, 1000.0), 1e-9);
  options.gates.working_distance_m = 5.0;
  EXPECT_NEAR(epipolar(10.0, 1000.0), 200 * 0.19, 1e-9);
}

TEST(TrackLife, AgesGrowWithTheIntervalAtLowFrameRates) {
  TrackLifeOptions options;
  options.in_seconds = true;
  options.max_age_s = 0.4;
  options.max_gap_s = 0.2;
  const struct {
    double rate_hz;
    double age_frames;
  } kCases[] = {{25.0, 10.0},
                {12.5, 5.0},
                // Below 12.5 Hz five frames, but no longer than five times
                // max_age_s, 2 s.
                {4.0, 5.0},
                {1.0, 2.0},
                {0.1, 0.2}};
  for (const auto& one : kCases) {
    const TrackLifeOptions life = LifeInFrames(options, one.rate_hz);
    EXPECT_NEAR(life.max_age_frames, one.age_frames, 1e-12) << one.rate_hz;
    EXPECT_NEAR(life.max_gap_frames, 0.5 * one.age_frames, 1e-12);
  }
}

}  // namespace
}  // namespace kinegraph
