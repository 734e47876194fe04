
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "core/tracking/options.h"

namespace kinegraph {
namespace {

// Cameras on a circle of that radius, looking at its centre.
CameraRig Circle(int count, double radius_m, double focal_px) {
  CameraRig cameras;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * 3.14159265358979 * i / count;
    const Eigen::Vector3d centre(radius_m * std::cos(angle),
                                 radius_m * std::sin(angle), 1.0);
    const Eigen::Vector3d forward =
        (Eigen::Vector3d(0.0, 0.0, 1.0) - centre).normalized();
    const Eigen::Vector3d down(0.0, 0.0, -1.0);
    CameraParameters parameters;
    parameters.name = "cam" + std::to_string(i);
    parameters.K << focal_px, 0, 500, 0, focal_px, 400, 0, 0, 1;
    parameters.R.row(0) = down.cross(forward).transpose();
    parameters.R.row(1) = down.transpose();
    parameters.R.row(2) = forward.transpose();
    parameters.t = -parameters.R * centre;
    cameras.emplace_back(parameters);
  }
  return cameras;
}

TEST(Gates, WorkingDistanceIsWhereTheAxesMeet) {
  EXPECT_NEAR(WorkingDistance(Circle(5, 6.0, 1000.0)), 6.0, 1e-9);
  EXPECT_NEAR(WorkingDistance(Circle(3, 0.9, 1000.0)), 0.9, 1e-9);
}

TEST(Gates, ParallelOrFewAxesGiveTheUsualDistance) {
  CameraRig cameras = Circle(1, 6.0, 1000.0);
  EXPECT_EQ(WorkingDistance(cameras), 4.0);
  CameraParameters beside;
  beside.name = "beside";
  beside.K = cameras[0].K();
  beside.R = cameras[0].R();
  beside.t = cameras[0].t() + Eigen::Vector3d(0.5, 0.0, 0.0);
  cameras.emplace_back(beside);
  EXPECT_EQ(WorkingDistance(cameras), 4.0);
}

TEST(Gates, PixelsStayThePapersUnlessAskedFor) {
  const TrackerOptions options;
  const TrackerOptions same =
      WithScaledGates(options, Circle(4, 3.0, 2000.0), 120.0);
  EXPECT_EQ(same.association.alpha_2d_px_per_frame, 70.0);
  EXPECT_EQ(same.reconstruction.alpha_epi_px, 60.0);
  EXPECT_EQ(same.reconstruction.tau_frames, 3.0);
}

// Worked by hand for 1000 px at 5 m, 200 px/m, and 50 Hz.
TEST(Gates, MetresAndSecondsBecomePixelsAndFrames) {
  TrackerOptions options;
  options.gates.units = GateUnits::kMetres;
  const TrackerOptions scaled =
      WithScaledGates(options, Circle(4, 5.0, 1000.0), 50.0);
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

// The same scene in half the size with the cameras at half the distance asks
// for the same gates per person: pixels that grow with the image of a person.
TEST(Gates, GrowWithFocalLengthAndShrinkWithDistance) {
  TrackerOptions options;
  options.gates.units = GateUnits::kMetres;
  options.gates.detector_px = 0.0;
  const auto epipolar = [&](double radius_m, double focal_px) {
    return WithScaledGates(options, Circle(4, radius_m, focal_px), 25.0)
        .reconstruction.alpha_epi_px;
  };
  EXPECT_NEAR(epipolar(5.0, 2000.0), 2.0 * epipolar(5.0, 1000.0), 1e-9);
  EXPECT_NEAR(epipolar(10.0, 1000.0), 0.5 * epipolar(5.0, 1000.0), 1e-9);
  options.gates.working_distance_m = 5.0;
  EXPECT_NEAR(epipolar(10.0, 1000.0), 200 * 0.19, 1e-9);
}

}  // namespace
}  // namespace kinegraph
