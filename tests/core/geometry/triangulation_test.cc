#include "core/geometry/triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/random.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

std::vector<PointMeasurement> Measure(const CameraRig& cameras,
                                      const Eigen::Vector3d& point,
                                      double noise_px, Random* random) {
  std::vector<PointMeasurement> measurements;
  for (const Camera& camera : cameras) {
    PointMeasurement m;
    m.camera = &camera;
    m.ideal_px = *camera.Project(point) +
                 noise_px * Eigen::Vector2d(random->Normal(), random->Normal());
    measurements.push_back(m);
  }
  return measurements;
}

Eigen::Vector3d RandomPoint(Random* random) {
  const double x = random->Uniform(-1, 1), y = random->Uniform(-1, 1);
  return {x, y, random->Uniform(0, 2)};
}

// The textbook method: singular value decomposition of the rows of A.
Eigen::Vector3d BySvd(const std::vector<PointMeasurement>& measurements) {
  Eigen::MatrixXd A(2 * measurements.size(), 4);
  for (size_t i = 0; i < measurements.size(); ++i) {
    const PointMeasurement& m = measurements[i];
    const Matrix34d& P = m.camera->P();
    A.row(2 * i) =
        m.weight * (m.ideal_px.x() * P.row(2) - P.row(0)).normalized();
    A.row(2 * i + 1) =
        m.weight * (m.ideal_px.y() * P.row(2) - P.row(1)).normalized();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeFullV);
  return svd.matrixV().col(3).hnormalized();
}

TEST(TriangulationTest, ExactMeasurementsGiveThePoint) {
  Random random(1);
  for (int views = 2; views <= 40; ++views) {
    const CameraRig cameras = testing::RingOfCameras(views, 4.0);
    const Eigen::Vector3d point = RandomPoint(&random);
    const auto result = TriangulateDlt(Measure(cameras, point, 0.0, &random));
    ASSERT_TRUE(result.ok()) << static_cast<int>(result.status);
    // Pixels of 1e3 at 1e-16 are 1e-13 px, 4e-16 m at this distance; the
    // worst conditioned pair (opposite cameras) loses four digits.
    EXPECT_LT((result.point_m - point).norm(), 1e-10) << views << " views";
  }
}

// Any noise and weights, and enough views that rows are reduced in portions.
// Omitting one view would move the point by far more than the tolerance.
TEST(TriangulationTest, EqualsSingularValueDecomposition) {
  Random random(2);
  for (const int views :
       {2, 3, 4, 5, 6, 15, 16, 17, 30, 31, 32, 33, 64, 65, 100}) {
    const CameraRig cameras = testing::RingOfCameras(views, 4.0);
    for (const double noise_px : {0.5, 5.0, 50.0}) {
      for (int round = 0; round < 15; ++round) {
        const Eigen::Vector3d point = RandomPoint(&random);
        auto measurements = Measure(cameras, point, noise_px, &random);
        for (PointMeasurement& m : measurements) {
          m.weight = random.Uniform(0.2, 1.0);
        }
        const Eigen::Vector3d expected = BySvd(measurements);
        const auto result = TriangulateDlt(measurements, {0.0, false});
        ASSERT_TRUE(result.ok());
        EXPECT_LT((result.point_m - expected).norm(), 1e-8 * expected.norm())
            << views << " views";
        // Weights of 1 and exp(-15), that of a view three frames old with
        // lambda_t = 5: rounding is 1e-16 / 3e-7, with two digits to spare; the
        // squared condition of the normal equations would leave three digits.
        if (views != 3 || noise_px > 5.0) continue;
        measurements.resize(2);
        measurements[0].weight = 1.0;
        measurements[1].weight = std::exp(-15.0);
        EXPECT_LT(
            (TriangulateDlt(measurements).point_m - BySvd(measurements)).norm(),
            1e-7);
      }
    }
  }
}

TEST(TriangulationTest, ErrorGrowsAsTheoryPredicts) {
  // Two nearly orthogonal rays of 4.1 m, with a focal length of 1000 px: each
  // determines the directions perpendicular to it to sigma * 4.1 / 1000 m;
  // heights are measured by both.
  CameraRig ring = testing::RingOfCameras(4, 4.0);
  const CameraRig cameras = {ring[0], ring[1]};
  const Eigen::Vector3d point(0.0, 0.0, 1.0);
  Random random(4);
  constexpr double kSigmaPx = 2.0;
  constexpr int kRounds = 4000;
  Matrix23d jacobian;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const Camera& camera : cameras) {
    camera.Project(point, &jacobian);
    information += jacobian.transpose() * jacobian / (kSigmaPx * kSigmaPx);
  }
  const double predicted = information.inverse().trace();
  double measured = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const auto result =
        TriangulateDlt(Measure(cameras, point, kSigmaPx, &random));
    ASSERT_TRUE(result.ok());
    measured += (result.point_m - point).squaredNorm() / kRounds;
  }
  // Relative standard error of a mean of squares of three normal variables:
  // sqrt(2 / (3 * 4000)) = 1.3 %; the tolerance is five times that, and DLT is
  // not quite optimal.
  EXPECT_NEAR(measured / predicted, 1.0, 0.07);
}

TEST(TriangulationTest, FailuresHaveAStatus) {
  const CameraRig cameras = testing::RingOfCameras(4, 4.0);
  Random random(5);
  const auto exact = Measure(cameras, {0, 0, 1}, 0.0, &random);

  using Measurements = std::vector<PointMeasurement>;
  const auto status_of = [](const Measurements& measurements) {
    return TriangulateDlt(measurements).status;
  };
  EXPECT_EQ(status_of({}), TriangulationStatus::kTooFewViews);
  EXPECT_EQ(status_of({exact[0]}), TriangulationStatus::kTooFewViews);
  auto weightless = exact;
  for (size_t i = 1; i < 4; ++i) weightless[i].weight = 0.0;
  EXPECT_EQ(status_of(weightless), TriangulationStatus::kTooFewViews);
  auto broken = exact;
  broken[2].ideal_px.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(status_of(broken), TriangulationStatus::kNotFinite);
  // One camera twice: the rays are the same line. A view without weight adds no
  // parallax to them.
  EXPECT_EQ(status_of({exact[0], exact[0]}),
            TriangulationStatus::kParallelRays);
  EXPECT_EQ(status_of({weightless[1], exact[0], exact[0], weightless[1]}),
            TriangulationStatus::kParallelRays);

  // Rays that meet behind both cameras: a stereo pair with its images
  // exchanged.
  CameraParameters left;
  left.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  CameraParameters right = left;
  right.t.x() = -1.0;
  const Camera left_camera(left);
  const Camera right_camera(right);
  const Eigen::Vector3d point(0.5, 0.0, 5.0);
  EXPECT_EQ(status_of({{&left_camera, *right_camera.Project(point), 1.0},
                       {&right_camera, *left_camera.Project(point), 1.0}}),
            TriangulationStatus::kBehindCamera);
}

}  // namespace
}  // namespace kinegraph
