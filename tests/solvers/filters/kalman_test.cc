#include "solvers/filters/kalman.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "solvers/filters/offline_filter.h"
#include "tests/support/signals.h"

namespace kinegraph {
namespace {

PointModel Model(int derivatives, double power) {
  PointModel model;
  model.derivatives = derivatives;
  model.power = power;
  return model;
}

// Three different coordinates with varying, non-diagonal covariances; frames 8
// to 11 are bridged.
JointSegment Uneven() {
  constexpr int kCount = 20;
  JointSegment segment;
  segment.times_s = testing::UnevenTimes(kCount);
  const double start_s = segment.times_s[0];
  for (double& time_s : segment.times_s) time_s -= start_s;
  segment.positions_m.resize(kCount, 3);
  segment.positions_m << testing::Wiggle(kCount),
      -0.5 * testing::Wiggle(kCount), testing::Wiggle(kCount).cwiseAbs2();
  segment.sampled.assign(kCount, 1);
  for (int k = 0; k < kCount; ++k) {
    if (k >= 8 && k < 12) segment.sampled[k] = 0;
    const Eigen::Vector3d ray(1.0, std::sin(k), 0.3 * k);
    segment.covariances_m2.emplace_back(
        1e-4 * (1.0 + 0.1 * k) * Eigen::Matrix3d::Identity() +
        1e-3 * ray * ray.transpose() / ray.squaredNorm());
  }
  return segment;
}

// The filter and the smoother without recursion: position is a Gaussian process
// whose covariance is known in closed form (integrals of white noise; Rasmussen
// and Williams, Gaussian Processes for Machine Learning, section 6.3), and the
// estimate is its conditional mean given the samples.
double ProcessCovariance(const PointModel& model, double s, double t) {
  const double a = std::min(s, t);
  const double d = std::max(s, t) - a;
  const double velocity = std::pow(PointModel::kStartSigmas[0], 2) * s * t;
  if (model.derivatives == 2) {
    return velocity + model.power * (a * a * a / 3.0 + d * a * a / 2.0);
  }
  return velocity + 0.25 * std::pow(PointModel::kStartSigmas[1] * s * t, 2) +
         0.25 * model.power *
             (std::pow(a, 5) / 5.0 + d * std::pow(a, 4) / 2.0 +
              d * d * a * a * a / 3.0);
}

SegmentEstimate Conditional(const PointModel& model,
                            const JointSegment& segment, bool smooth) {
  const auto covariance = [&](size_t i, size_t k) -> Eigen::Matrix3d {
    return segment.covariances_m2[0] +
           ProcessCovariance(model, segment.times_s[i], segment.times_s[k]) *
               Eigen::Matrix3d::Identity();
  };
  const size_t count = segment.times_s.size();
  SegmentEstimate estimate;
  estimate.positions_m.resize(static_cast<Eigen::Index>(count), 3);
  for (size_t i = 0; i < count; ++i) {
    std::vector<size_t> given;
    for (size_t k = 1; k < count && (smooth || k <= i); ++k) {
      if (segment.sampled[k]) given.push_back(k);
    }
    const Eigen::Index n = 3 * static_cast<Eigen::Index>(given.size());
    Eigen::MatrixXd S(n, n);
    Eigen::MatrixXd cross(3, n);
    Eigen::VectorXd innovation(n);
    for (size_t a = 0; a < given.size(); ++a) {
      const Eigen::Index ra = 3 * static_cast<Eigen::Index>(a);
      for (size_t b = 0; b < given.size(); ++b) {
        S.block<3, 3>(ra, 3 * static_cast<Eigen::Index>(b)) =
            covariance(given[a], given[b]);
      }
      S.block<3, 3>(ra, ra) += segment.covariances_m2[given[a]];
      cross.block<3, 3>(0, ra) = covariance(i, given[a]);
      innovation.segment<3>(ra) =
          (segment.positions_m.row(static_cast<Eigen::Index>(given[a])) -
           segment.positions_m.row(0))
              .transpose();
    }
    const Eigen::MatrixXd K =
        n == 0 ? Eigen::MatrixXd(3, 0)
               : Eigen::MatrixXd(S.ldlt().solve(cross.transpose()).transpose());
    estimate.positions_m.row(static_cast<Eigen::Index>(i)) =
        segment.positions_m.row(0) + (K * innovation).transpose();
    estimate.covariances_m2.emplace_back(covariance(i, i) -
                                         K * cross.transpose());
  }
  return estimate;
}

// A uniformly accelerated point, measured to a micrometre.
TEST(KalmanTest, DerivativesMatchTheMotion) {
  JointSegment segment;
  segment.times_s = testing::UniformTimes(40);
  segment.positions_m.resize(40, 3);
  segment.sampled.assign(40, 1);
  segment.covariances_m2.assign(40, 1e-12 * Eigen::Matrix3d::Identity());
  const Eigen::RowVector3d v(1.0, -0.5, 0.2);
  const Eigen::RowVector3d a(0.3, 2.0, -1.0);
  for (Eigen::Index k = 0; k < 40; ++k) {
    const double t = segment.times_s[static_cast<size_t>(k)];
    segment.positions_m.row(k) = t * v + 0.5 * t * t * a;
  }
  const SegmentEstimate third = RtsSmoother(Model(3, 1e-6), segment);
  ASSERT_EQ(third.velocities_m_s.rows(), 40);
  ASSERT_EQ(third.accelerations_m_s2.rows(), 40);
  for (Eigen::Index k = 0; k < 40; ++k) {
    const double t = segment.times_s[static_cast<size_t>(k)];
    EXPECT_LT((third.velocities_m_s.row(k) - v - t * a).norm(), 1e-4);
    EXPECT_LT((third.accelerations_m_s2.row(k) - a).norm(), 1e-3);
  }
  const SegmentEstimate second = RtsSmoother(Model(2, 2.0), segment);
  EXPECT_EQ(second.accelerations_m_s2.rows(), 0);
  // The error of the constant-velocity model is at most the acceleration times
  // half a frame.
  const double step_s = segment.times_s[1] - segment.times_s[0];
  EXPECT_LT(
      (second.velocities_m_s.row(20) - v - segment.times_s[20] * a).norm(),
      0.5 * step_s * a.norm());
}

TEST(KalmanTest, FilterAndSmootherEqualTheGaussianConditional) {
  const JointSegment segment = Uneven();
  for (const PointModel& model : {Model(2, 2.0), Model(3, 90.0)}) {
    for (const bool smooth : {false, true}) {
      const SegmentEstimate found =
          smooth ? RtsSmoother(model, segment) : KalmanFilter(model, segment);
      const SegmentEstimate expected = Conditional(model, segment, smooth);
      ASSERT_EQ(found.covariances_m2.size(), 20u);
      // The dense system's condition is about 1e6: 1e-10 of rounding.
      EXPECT_LT(
          (found.positions_m - expected.positions_m).cwiseAbs().maxCoeff(),
          1e-9)
          << model.derivatives << smooth;
      for (size_t k = 0; k < 20; ++k) {
        EXPECT_LT((*found.covariances_m2[k] - *expected.covariances_m2[k])
                      .cwiseAbs()
                      .maxCoeff(),
                  1e-10)
            << model.derivatives << smooth << " at " << k;
      }
    }
  }
}

// One sample has an error of half a metre along each axis.
JointSegment WithOutlier(size_t at) {
  JointSegment segment = Uneven();
  segment.positions_m.row(static_cast<Eigen::Index>(at)).array() += 0.5;
  return segment;
}

// Runs the smoother with the covariances that follow from the result: it must
// reproduce the result up to the effect of the weights' last step of 1e-6.
TEST(KalmanTest, StudentTIsAFixedPoint) {
  const PointModel model = Model(2, 50.0);
  const JointSegment segment = WithOutlier(4);
  const SegmentEstimate estimate = StudentTSmoother(model, segment);
  JointSegment weighted = segment;
  std::vector<double> weights;
  for (size_t k = 0; k < segment.times_s.size(); ++k) {
    if (!segment.sampled[k]) continue;
    const auto row = static_cast<Eigen::Index>(k);
    const Eigen::Vector3d e =
        (segment.positions_m.row(row) - estimate.positions_m.row(row))
            .transpose();
    const Eigen::Matrix3d information = segment.covariances_m2[k].inverse();
    weights.push_back(7.0 /
                      (4.0 + e.dot(information * e) +
                       (information * *estimate.covariances_m2[k]).trace()));
    weighted.covariances_m2[k] /= weights.back();
  }
  EXPECT_LT((RtsSmoother(model, weighted).positions_m - estimate.positions_m)
                .cwiseAbs()
                .maxCoeff(),
            1e-5);
  EXPECT_LT(*std::min_element(weights.begin(), weights.end()), 0.1);
  EXPECT_GT(*std::max_element(weights.begin(), weights.end()), 1.0);
}

TEST(KalmanTest, StudentTIgnoresAnOutlier) {
  const PointModel model = Model(2, 50.0);
  const auto moved_m = [&](auto smoother) {
    return (smoother(model, WithOutlier(4)).positions_m -
            smoother(model, Uneven()).positions_m)
        .cwiseAbs()
        .maxCoeff();
  };
  EXPECT_LT(moved_m(StudentTSmoother), 0.2 * moved_m(RtsSmoother));
}

TEST(KalmanTest, OptionsChooseModelAndNoise) {
  JointSegment segment = Uneven();
  segment.joint_class = JointClass::kWrist;
  KalmanOptions options;
  options.motion = MotionModel::kConstantAcceleration;
  options.process_noise_scale = 2.0;
  PointModel model = ModelOf(options, JointClass::kWrist);
  EXPECT_EQ(model.derivatives, 3);
  // 25 / s^2 times the wrist's default of 6 m^2/s^3, times the scale of 2.
  EXPECT_EQ(model.power, 300.0);
  EXPECT_EQ(RtsPointSmoother(options)(segment).positions_m,
            RtsSmoother(model, segment).positions_m);
  options.measurement = MeasurementNoise::kConstant;
  options.sigma_m[static_cast<size_t>(JointClass::kWrist)] = 0.05;
  for (auto& covariance : segment.covariances_m2) {
    covariance = 0.0025 * Eigen::Matrix3d::Identity();
  }
  EXPECT_EQ(KalmanPointFilter(options)(Uneven()).positions_m.rows(), 20);
  JointSegment given = Uneven();
  given.joint_class = JointClass::kWrist;
  EXPECT_TRUE(KalmanPointFilter(options)(given).positions_m.isApprox(
      KalmanFilter(model, segment).positions_m, 1e-12));
}

}  // namespace
}  // namespace kinegraph
