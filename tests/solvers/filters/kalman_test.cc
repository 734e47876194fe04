#include "solvers/filters/kalman.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/base/random.h"
#include "solvers/filters/segment_filters.h"
#include "solvers/filters/smoothing_spline.h"
#include "tests/support/signals.h"

namespace kinegraph {
namespace {

PointModel Model(int derivatives, double power) {
  PointModel model;
  model.derivatives = derivatives;
  model.power = power;
  model.start_sigmas = {3.0, 30.0};
  return model;
}

// Three coordinates of their own, with covariances that differ from time to
// time and lie askew; frames 8 to 11 are bridged.
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
    if (k >= 8 && k < 12) segment.sampled[static_cast<size_t>(k)] = 0;
    const Eigen::Vector3d ray(1.0, std::sin(k), 0.3 * k);
    segment.covariances_m2.emplace_back(
        1e-4 * (1.0 + 0.1 * k) * Eigen::Matrix3d::Identity() +
        1e-3 * ray * ray.transpose() / ray.squaredNorm());
  }
  return segment;
}

// The same without any recursion: position is a Gaussian process whose
// covariance is known in closed form (integrals of white noise; Rasmussen and
// Williams, Gaussian Processes for Machine Learning, section 6.3), and the
// estimate its conditional mean given the samples.
double ProcessCovariance(const PointModel& model, double s, double t) {
  const double a = std::min(s, t);
  const double d = std::max(s, t) - a;
  const double velocity = std::pow(model.start_sigmas[0], 2) * s * t;
  if (model.derivatives == 2) {
    return velocity + model.power * (a * a * a / 3.0 + d * a * a / 2.0);
  }
  return velocity + 0.25 * std::pow(model.start_sigmas[1] * s * t, 2) +
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

TEST(KalmanTest, FilterAndSmootherAreTheConditionalOfTheProcess) {
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

TEST(KalmanTest, FilterIsCausal) {
  JointSegment segment = Uneven();
  const SegmentEstimate before = KalmanFilter(Model(2, 2.0), segment);
  segment.positions_m.bottomRows(5).setConstant(7.0);
  const SegmentEstimate after = KalmanFilter(Model(2, 2.0), segment);
  EXPECT_EQ(before.positions_m.topRows(15), after.positions_m.topRows(15));
}

TEST(KalmanTest, SteadyStateIsScipys) {
  // dt = 0.04, R = 0.03**2, F and Q as the models say, power 2 or 90:
  //   P = scipy.linalg.solve_discrete_are(F.T, H.T, Q, R)
  //   K = P[:, :1] / (P[0, 0] + R); Pf = P - K @ H @ P
  //   G = Pf @ F.T @ np.linalg.inv(P)
  //   Ps = scipy.linalg.solve_discrete_lyapunov(G, Pf - G @ P @ G.T)
  const struct {
    PointModel model;
    double filtered, smoothed, gain;
  } cases[] = {{Model(2, 2.0), 0.0005223502109331056, 0.0001953526328960032,
                0.580389123259006},
               {Model(3, 90.0), 0.0005456091576543289, 0.0001397991064953762,
                0.606232397393699}};
  for (const auto& expected : cases) {
    JointSegment segment;
    segment.times_s = testing::UniformTimes(401);
    segment.positions_m = testing::Step(401, 400).replicate(1, 3);
    segment.sampled.assign(401, 1);
    segment.covariances_m2.assign(401, 9e-4 * Eigen::Matrix3d::Identity());
    const SegmentEstimate filtered = KalmanFilter(expected.model, segment);
    EXPECT_NEAR((*filtered.covariances_m2[300])(1, 1), expected.filtered,
                1e-14);
    EXPECT_NEAR((*filtered.covariances_m2[300])(0, 1), 0.0, 1e-18);
    EXPECT_NEAR(filtered.positions_m(400, 0), expected.gain, 1e-12)
        << "the first answer to a step is the gain";
    const SegmentEstimate smoothed = RtsSmoother(expected.model, segment);
    EXPECT_NEAR((*smoothed.covariances_m2[200])(2, 2), expected.smoothed,
                1e-14);
  }
}

TEST(KalmanTest, SmootherIsTheSmoothingSpline) {
  // With constant velocity, nothing known at the start and noise r, power q, it
  // is the smoothing spline of lambda = r^2 / q (Wahba 1978): step, impulse,
  // uneven time, and with them the frequency response of the spline's test. A
  // start velocity of 1e4 m/s leaves (0.01 / 0.04 / 1e4)^2 = 6e-10.
  PointModel model = Model(2, 2.0);
  model.start_sigmas = {1e4, 1e4};
  JointSegment segment;
  segment.times_s = testing::UnevenTimes(41);
  segment.positions_m.resize(41, 3);
  segment.positions_m << testing::Wiggle(41), testing::Step(41, 20),
      testing::Impulse(41, 20);
  segment.sampled.assign(41, 1);
  segment.covariances_m2.assign(41, 1e-4 * Eigen::Matrix3d::Identity());
  EXPECT_LT((RtsSmoother(model, segment).positions_m -
             SmoothingSpline(1e-4 / 2.0, segment.times_s, segment.positions_m,
                             segment.times_s))
                .cwiseAbs()
                .maxCoeff(),
            1e-7);
}

TEST(KalmanTest, CovarianceGrowsInAGapAndFallsBeforeTheNextSample) {
  const SegmentEstimate smoothed = RtsSmoother(Model(2, 2.0), Uneven());
  const auto trace = [&](size_t k) {
    return smoothed.covariances_m2[k]->trace();
  };
  EXPECT_LT(trace(7), trace(8));
  EXPECT_LT(trace(8), trace(9));
  EXPECT_GT(trace(10), trace(11));
  EXPECT_GT(trace(11), trace(12));
}

TEST(KalmanTest, CovariancesAreThoseOfTheErrors) {
  // Motion and noise drawn from the model itself: the normalised squared error
  // of one frame, summed over 400 seeds, is chi-square with 1200 degrees of
  // freedom; within four of its standard deviations, sqrt(2400).
  const PointModel model = Model(2, 2.0);
  Random random(7);
  double filter_sum = 0.0;
  double smoother_sum = 0.0;
  constexpr int kSeeds = 400;
  for (int seed = 0; seed < kSeeds; ++seed) {
    JointSegment segment;
    segment.times_s = testing::UniformTimes(30);
    segment.positions_m.resize(30, 3);
    segment.sampled.assign(30, 1);
    segment.covariances_m2.assign(30, 4e-4 * Eigen::Matrix3d::Identity());
    const Eigen::Matrix2d L = ProcessNoise(2, 2.0, 0.04).llt().matrixL();
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity;
    for (double& v : velocity) v = random.Normal(0.0, 3.0);
    Eigen::Vector3d truth = position;
    for (int k = 0; k < 30; ++k) {
      for (int c = 0; c < 3 && k > 0; ++c) {
        const double first = random.Normal(0.0, 1.0);
        const double second = random.Normal(0.0, 1.0);
        position(c) += 0.04 * velocity(c) + L(0, 0) * first;
        velocity(c) += L(1, 0) * first + L(1, 1) * second;
      }
      if (k == 15) truth = position;
      for (int c = 0; c < 3; ++c) {
        segment.positions_m(k, c) = position(c) + random.Normal(0.0, 0.02);
      }
    }
    const auto squared = [&](const SegmentEstimate& estimate) {
      const Eigen::Vector3d error =
          estimate.positions_m.row(15).transpose() - truth;
      return error.dot(estimate.covariances_m2[15]->ldlt().solve(error));
    };
    filter_sum += squared(KalmanFilter(model, segment));
    smoother_sum += squared(RtsSmoother(model, segment));
  }
  EXPECT_NEAR(filter_sum, 1200.0, 4.0 * std::sqrt(2400.0));
  EXPECT_NEAR(smoother_sum, 1200.0, 4.0 * std::sqrt(2400.0));
}

TEST(KalmanTest, OptionsChooseModelAndNoise) {
  JointSegment segment = Uneven();
  segment.joint_class = JointClass::kWrist;
  KalmanOptions options;
  options.motion = MotionModel::kConstantAcceleration;
  options.process_noise_scale = 2.0;
  PointModel model = ModelOf(options, JointClass::kWrist);
  EXPECT_EQ(model.derivatives, 3);
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
