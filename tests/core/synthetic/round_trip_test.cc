// Truth in, truth out: what the cameras of a synthetic scene see gives the
// scene back, and noise comes through as triangulation theory says.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <optional>
#include <vector>

#include "core/geometry/triangulation.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct Measurement {
  const Camera* camera;
  Vector2d px;
};

// Every joint of every person and frame: its true place and what saw it.
struct JointViews {
  Vector3d truth;
  std::vector<Measurement> seen;
};

std::vector<JointViews> Collect(const Scene& scene, const NoiseOptions& noise) {
  ObservationTruth labels;
  const DetectionSequence detections = Observe(scene, noise, &labels);
  const TrackSequence truth = TruthFor(scene, detections);
  std::vector<JointViews> joints;
  for (size_t f = 0; f < detections.frames.size(); ++f) {
    for (const PersonPose& person : truth.frames[f].people) {
      std::vector<JointViews> of_person(person.joints.size());
      for (size_t j = 0; j < of_person.size(); ++j) {
        of_person[j].truth = person.joints[j].position_m;
      }
      for (size_t v = 0; v < scene.cameras.size(); ++v) {
        for (size_t d = 0; d < labels.frames[f][v].size(); ++d) {
          if (labels.frames[f][v][d].person != person.id.value()) continue;
          const auto& seen = detections.frames[f].views[v].detections[d];
          for (size_t j = 0; j < of_person.size(); ++j) {
            if (!seen.joints[j].found) continue;
            of_person[j].seen.push_back({&scene.cameras[v], seen.joints[j].px});
          }
        }
      }
      joints.insert(joints.end(), of_person.begin(), of_person.end());
    }
  }
  return joints;
}

std::optional<Vector3d> Triangulate(const JointViews& joint) {
  std::vector<PointMeasurement> measurements;
  for (const Measurement& seen : joint.seen) {
    const auto ideal = seen.camera->Undistort(seen.px);
    if (!ideal.has_value()) return std::nullopt;
    measurements.push_back({seen.camera, *ideal, 1.0});
  }
  const TriangulationResult result = TriangulateDlt(measurements);
  if (!result.ok()) return std::nullopt;
  return result.point_m;
}

Scene DistortedScene(int64_t people) {
  SceneOptions options;
  options.seed = 31;
  options.people = people;
  options.duration_s = 8.0;
  options.skeleton = "body25";
  options.cameras.count = 5;
  options.cameras.distortion = {-0.2, 0.06, 0.001, -0.002, -0.005};
  return MakeScene(options);
}

TEST(RoundTrip, ExactProjectionsGiveTheSceneBack) {
  const Scene scene = DistortedScene(4);
  int checked = 0;
  double worst = 0.0;
  for (const JointViews& joint : Collect(scene, NoiseOptions())) {
    if (joint.seen.size() < 2) continue;
    const auto point = Triangulate(joint);
    ASSERT_TRUE(point.has_value());
    // The lens is inverted to 1e-7 of the focal length at worst and to 1e-13
    // as a rule: far below a micrometre at 10 m.
    worst = std::max(worst, (*point - joint.truth).norm());
    ++checked;
  }
  EXPECT_LT(worst, 1e-6);
  EXPECT_GT(checked, 10000);
}

// Least squares in pixels from a DLT start, and the covariance that theory
// gives it: sigma^2 (sum of J'J)^-1.
struct Estimate {
  Vector3d point_m;
  Matrix3d covariance;
};

std::optional<Estimate> LeastSquares(const JointViews& joint, double sigma_px) {
  const auto start = Triangulate(joint);
  if (!start.has_value()) return std::nullopt;
  Estimate estimate;
  estimate.point_m = *start;
  for (int iteration = 0; iteration < 5; ++iteration) {
    Matrix3d information = Matrix3d::Zero();
    Vector3d gradient = Vector3d::Zero();
    for (const Measurement& seen : joint.seen) {
      Matrix23d jacobian;
      const auto px = seen.camera->Project(estimate.point_m, &jacobian);
      if (!px.has_value()) return std::nullopt;
      information += jacobian.transpose() * jacobian;
      gradient += jacobian.transpose() * (seen.px - *px);
    }
    estimate.point_m += information.ldlt().solve(gradient);
    estimate.covariance = sigma_px * sigma_px * information.inverse();
  }
  return estimate;
}

TEST(RoundTrip, ErrorGrowsWithPixelNoiseAsTheoryPredicts) {
  const Scene scene = DistortedScene(4);
  for (const double sigma_px : {0.25, 1.0, 4.0}) {
    NoiseOptions noise;
    noise.joints.sigma_px = sigma_px;
    double n = 0.0;
    double squared_error = 0.0;
    double predicted = 0.0;
    double fourth = 0.0;  // sum of 2 tr(S^2): variance of the squared errors
    double nees = 0.0;
    for (const JointViews& joint : Collect(scene, noise)) {
      // Two views nearly opposite leave the depth open; theory then needs more
      // than the first order.
      if (joint.seen.size() < 3) continue;
      const auto estimate = LeastSquares(joint, sigma_px);
      if (!estimate.has_value()) continue;
      const Vector3d error = estimate->point_m - joint.truth;
      n += 1.0;
      squared_error += error.squaredNorm();
      predicted += estimate->covariance.trace();
      fourth += 2.0 * (estimate->covariance * estimate->covariance).trace();
      nees += error.dot(estimate->covariance.ldlt().solve(error));
    }
    ASSERT_GT(n, 10000);
    // Errors are independent between joints and frames: five standard
    // deviations of the sum of squares, and 2 % for the second order at 4 px
    // (angles of 4/800 rad against baselines of a radian: some 1e-2).
    EXPECT_NEAR(squared_error / predicted, 1.0,
                5.0 * std::sqrt(fourth) / predicted + 0.005 * sigma_px)
        << "at " << sigma_px << " px";
    // Chi-square with 3 n degrees of freedom.
    EXPECT_NEAR(nees / n, 3.0, 5.0 * std::sqrt(6.0 / n) + 0.005 * sigma_px)
        << "at " << sigma_px << " px";
  }
}

}  // namespace
}  // namespace kinegraph
