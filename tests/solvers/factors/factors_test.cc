// Compares factors with hand-computed values, their residuals at the truth with
// zero, and their Jacobians with central differences and an automatically
// differentiated twin.
#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>

#include "core/base/random.h"
#include "solvers/ceres/ceres_factor.h"
#include "solvers/graph/factor_list.h"
#include "tests/support/factor_checks.h"

namespace kinegraph {
namespace {

// The checks expect Ceres cost functions.
using ReprojectionFactor = CeresFactor<CameraReprojection>;
using ConstantVelocityFactor = CeresFactor<ConstantVelocity<double>>;
using BoneLengthFactor = CeresFactor<BoneLength<double>>;
using GaussianPriorFactor = CeresFactor<GaussianPrior<double>>;

CameraReprojection Pixel(const Camera* camera, const Eigen::Vector2d& px,
                         double sigma_px, double offset_s) {
  PixelMeasurement measurement;
  measurement.camera = camera;
  measurement.px = px;
  measurement.sigma_px = sigma_px;
  measurement.offset_s = offset_s;
  return ReprojectionOf(measurement);
}

BoneLength<double> Bone02(double length_m) { return {length_m, 1.0 / 0.02}; }

using testing::Blocks;
using testing::Evaluate;
using testing::ExpectSoundJacobians;

Eigen::VectorXd RandomState(Random* random) {
  Eigen::VectorXd state(kStateSize);
  for (int i = 0; i < kStateSize; ++i) state(i) = random->Normal();
  return state;
}

// ---- reprojection ----

// Folds back at a radius of 1.05 (normalised).
constexpr std::array<double, 5> kLens = {-0.3, 0.0, 0.002, -0.001, 0.0};

// At (0, 0, -4) m, looking along +z, with x to the right.
Camera FrontCamera(bool with_lens) {
  CameraParameters parameters;
  parameters.name = "front";
  parameters.K << 1000.0, 0.0, 500.0, 0.0, 900.0, 400.0, 0.0, 0.0, 1.0;
  parameters.t = Eigen::Vector3d(0.0, 0.0, 4.0);
  if (with_lens) parameters.lens = std::make_shared<OpenCv5Lens>(kLens);
  return Camera(parameters);
}

struct ReprojectionTwin {
  template <typename T>
  bool operator()(const T* state, T* residual) const {
    const T z = state[2] + offset_s * state[5] + 4.0;
    const T x = (state[0] + offset_s * state[3]) / z;
    const T y = (state[1] + offset_s * state[4]) / z;
    const auto& [k1, k2, p1, p2, k3] = k;
    const T r2 = x * x + y * y;
    const T radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const T xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
    const T yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
    residual[0] = (1000.0 * xd + 500.0 - px.x()) / sigma_px;
    residual[1] = (900.0 * yd + 400.0 - px.y()) / sigma_px;
    return true;
  }
  std::array<double, 5> k;
  Eigen::Vector2d px;
  double sigma_px;
  double offset_s;
};

TEST(ReprojectionFactor, HandWorkedValue) {
  const Camera camera = FrontCamera(false);
  // 0.4 m right of the axis and 4 m away: 100 px right of the centre, measured
  // at 112 px; with a sigma of 3 px the residual is -4. The velocity of 1 m/s
  // downwards moves the point by 0.04 m in 0.04 s, i.e. by 9 px or +3 sigmas.
  const ReprojectionFactor factor(Pixel(&camera, {612.0, 400.0}, 3.0, 0.04));
  Eigen::VectorXd state(kStateSize);
  state << 0.4, 0.0, 0.0, 0.0, 1.0, 0.0;
  const auto result = Evaluate(factor, {state});
  ASSERT_TRUE(result.ok);
  EXPECT_NEAR(result.residuals(0), -4.0, 1e-12);
  EXPECT_NEAR(result.residuals(1), 3.0, 1e-12);
}

TEST(ReprojectionFactor, ZeroAtTruth) {
  const Camera camera = FrontCamera(true);
  const Eigen::Vector3d point(0.3, -0.5, 0.2);
  const ReprojectionFactor factor(
      Pixel(&camera, *camera.Project(point), 3.0, 0.0));
  Eigen::VectorXd state = Eigen::VectorXd::Constant(kStateSize, 7.0);
  state.head<3>() = point;
  EXPECT_EQ(Evaluate(factor, {state}).residuals, Eigen::Vector2d(0.0, 0.0));
}

TEST(ReprojectionFactor, Jacobians) {
  Random random(3);
  for (const bool with_lens : {false, true}) {
    const Camera camera = FrontCamera(with_lens);
    for (const double offset_s : {0.0, 0.013}) {
      const Eigen::Vector2d px(480.0, 333.0);
      const auto twin =
          std::make_unique<ceres::AutoDiffCostFunction<ReprojectionTwin, 2, 6>>(
              new ReprojectionTwin{with_lens ? kLens : std::array<double, 5>{},
                                   px, 2.5, offset_s});
      const ReprojectionFactor factor(Pixel(&camera, px, 2.5, offset_s));
      for (int i = 0; i < 5; ++i) {
        ExpectSoundJacobians(factor, *twin, {0.5 * RandomState(&random)});
      }
    }
  }
}

TEST(ReprojectionFactor, FailsBehindTheCameraAndOutsideTheLens) {
  const Camera plain = FrontCamera(false);
  const Camera lens = FrontCamera(true);
  Eigen::VectorXd behind = Eigen::VectorXd::Zero(kStateSize);
  behind(2) = -5.0;
  EXPECT_FALSE(Evaluate(ReprojectionFactor(Pixel(&plain, {0.0, 0.0}, 1.0, 0.0)),
                        {behind})
                   .ok);
  // Radius 10 in normalised units: far beyond the fold.
  Eigen::VectorXd outside = Eigen::VectorXd::Zero(kStateSize);
  outside(0) = 40.0;
  EXPECT_FALSE(Evaluate(ReprojectionFactor(Pixel(&lens, {0.0, 0.0}, 1.0, 0.0)),
                        {outside})
                   .ok);
}

// ---- constant velocity ----

struct ConstantVelocityTwin {
  template <typename T>
  bool operator()(const T* from, const T* to, T* residual) const {
    // Q = L L' by elimination, written independently of the factor.
    const double q11 = q * dt * dt * dt / 3.0;
    const double q12 = q * dt * dt / 2.0;
    const double q22 = q * dt;
    const double l11 = std::sqrt(q11);
    const double l21 = q12 / l11;
    const double l22 = std::sqrt(q22 - l21 * l21);
    for (int axis = 0; axis < 3; ++axis) {
      residual[axis] = (to[axis] - from[axis] - dt * from[axis + 3]) / l11;
      residual[axis + 3] =
          (to[axis + 3] - from[axis + 3] - l21 * residual[axis]) / l22;
    }
    return true;
  }
  double dt;
  double q;
};

TEST(ConstantVelocityFactor, HandWorkedValue) {
  // dt = 2, q = 3: Q = [8 6; 6 6], L = [sqrt 8, 0; 6 / sqrt 8, sqrt 1.5]. From
  // rest to p = 4, v = 3 along x: r = 4 / sqrt 8 = sqrt 2, then (3 - 6 / sqrt 8
  // * sqrt 2) / sqrt 1.5 = 0, because 3 is the expected velocity given p = 4.
  const ConstantVelocityFactor factor({2.0, 3.0});
  Eigen::VectorXd to = Eigen::VectorXd::Zero(kStateSize);
  to(0) = 4.0;
  to(3) = 3.0;
  const auto result = Evaluate(factor, {Eigen::VectorXd::Zero(kStateSize), to});
  EXPECT_NEAR(result.residuals(0), std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(result.residuals.tail(5).cwiseAbs().maxCoeff(), 0.0, 1e-14);
  // r'r is the squared Mahalanobis distance: [4 3] Q^-1 [4; 3] = 2.
  EXPECT_NEAR(result.residuals.squaredNorm(), 2.0, 1e-14);
}

TEST(ConstantVelocityFactor, ZeroAtConstantVelocity) {
  Random random(4);
  const Eigen::VectorXd from = RandomState(&random);
  Eigen::VectorXd to = from;
  to.head<3>() += 0.04 * from.tail<3>();
  const auto result = Evaluate(ConstantVelocityFactor({0.04, 1.0}), {from, to});
  // Rounding of the difference (1e-16) over sqrt(q dt^3 / 3) = 0.005.
  EXPECT_LT(result.residuals.cwiseAbs().maxCoeff(), 1e-13);
}

TEST(ConstantVelocityFactor, Jacobians) {
  Random random(5);
  for (const double dt : {1.0 / 120.0, 0.04, 1.0}) {
    const ConstantVelocityFactor factor({dt, 2.0});
    const ceres::AutoDiffCostFunction<ConstantVelocityTwin, 6, 6, 6> twin(
        new ConstantVelocityTwin{dt, 2.0});
    ExpectSoundJacobians(factor, twin,
                         {RandomState(&random), RandomState(&random)});
  }
}

// ---- birth prior ----

struct BirthPriorTwin {
  template <typename T>
  bool operator()(const T* state, T* residual) const {
    for (int axis = 0; axis < 3; ++axis) {
      residual[axis] = (state[axis] - centre(axis)) / 1.5;
      residual[axis + 3] = state[axis + 3] / 3.0;
    }
    return true;
  }
  Eigen::Vector3d centre;
};

TEST(BirthPrior, HandWorkedValueAndZero) {
  const StatePrior prior = BirthPrior({1.0, 2.0, 3.0}, 0.5, 2.0);
  const GaussianPriorFactor factor(PriorOf(prior, false));
  Eigen::VectorXd state(kStateSize);
  state << 2.0, 2.0, 2.0, 1.0, 0.0, -4.0;
  Eigen::VectorXd expected(kStateSize);
  expected << 2.0, 0.0, -2.0, 0.5, 0.0, -2.0;
  EXPECT_EQ(Evaluate(factor, {state}).residuals, expected);
  state << 1.0, 2.0, 3.0, 0.0, 0.0, 0.0;
  EXPECT_TRUE(Evaluate(factor, {state}).residuals.isZero(0.0));
}

TEST(BirthPrior, Jacobians) {
  Random random(6);
  const Eigen::Vector3d centre(1.0, -2.0, 0.5);
  const StatePrior prior = BirthPrior(centre, 1.5, 3.0);
  const GaussianPriorFactor factor(PriorOf(prior, false));
  const ceres::AutoDiffCostFunction<BirthPriorTwin, 6, 6> twin(
      new BirthPriorTwin{centre});
  ExpectSoundJacobians(factor, twin, {RandomState(&random)});
}

// ---- body centre ----

TEST(BodyCentreFactor, HandWorkedValueZeroAndJacobians) {
  const double centre_m[3] = {1.0, -2.0, 0.5};
  const CeresFactor<BodyCentre<double>> factor({centre_m, 0.5});
  Eigen::VectorXd at(6);
  at << 1.0, -2.0, 0.5, 3.0, 2.0, 1.0;
  EXPECT_TRUE(Evaluate(factor, {at}).residuals.isZero(0.0));
  at.head(3) += Eigen::Vector3d(2.0, 0.0, -4.0);
  EXPECT_EQ(Evaluate(factor, {at}).residuals, Eigen::Vector3d(1.0, 0.0, -2.0));
  // The Jacobian is 0.5 per metre for a sigma of two metres, zero for
  // velocities.
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(3, 6);
  expected.leftCols(3) = 0.5 * Eigen::Matrix3d::Identity();
  EXPECT_EQ(Evaluate(factor, {at}).jacobians[0], expected);
}

// ---- bone length ----

struct BoneTwin {
  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    T squared(0.0);
    for (int i = 0; i < 3; ++i) squared += (a[i] - b[i]) * (a[i] - b[i]);
    residual[0] = (sqrt(squared) - 0.4) / 0.02;
    return true;
  }
};

TEST(BoneLengthFactor, HandWorkedValueAndZero) {
  Eigen::VectorXd a = Eigen::VectorXd::Zero(kStateSize);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(kStateSize);
  a.head<3>() << 0.3, 0.4, 0.0;  // 0.5 m apart
  EXPECT_NEAR(Evaluate(BoneLengthFactor(Bone02(0.4)), {a, b}).residuals(0), 5.0,
              1e-12);
  EXPECT_NEAR(Evaluate(BoneLengthFactor(Bone02(0.5)), {a, b}).residuals(0), 0.0,
              1e-12);
}

TEST(BoneLengthFactor, Jacobians) {
  Random random(7);
  const BoneLengthFactor factor(Bone02(0.4));
  const ceres::AutoDiffCostFunction<BoneTwin, 1, 6, 6> twin(new BoneTwin);
  for (int i = 0; i < 5; ++i) {
    ExpectSoundJacobians(factor, twin,
                         {RandomState(&random), RandomState(&random)});
  }
}

TEST(BoneLengthFactor, CoincidentEndsStayFinite) {
  const Eigen::VectorXd a = Eigen::VectorXd::Ones(kStateSize);
  const BoneLengthFactor factor(Bone02(0.4));
  const auto result = Evaluate(factor, {a, a});
  EXPECT_NEAR(result.residuals(0), -20.0, 1e-12);
  EXPECT_TRUE(result.jacobians[0].isZero(0.0));
  EXPECT_TRUE(result.jacobians[1].isZero(0.0));
  testing::ExpectAbsentJacobiansAreRespected(factor, {a, a});
}

// ---- marginal prior ----

struct MarginalTwin {
  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    for (int row = 0; row < A.rows(); ++row) {
      residual[row] = T(offset(row));
      for (int i = 0; i < 6; ++i) {
        residual[row] += A(row, i) * (a[i] - x0(i));
        residual[row] += A(row, i + 6) * (b[i] - x0(i + 6));
      }
    }
    return true;
  }
  Eigen::MatrixXd A;
  Eigen::VectorXd x0;
  Eigen::VectorXd offset;
};

TEST(PersonPrior, ValueAndJacobians) {
  Random random(8);
  Eigen::MatrixXd A(12, 12);
  for (Eigen::Index i = 0; i < A.size(); ++i) A.data()[i] = random.Normal();
  Eigen::VectorXd x0(12);
  x0 << RandomState(&random), RandomState(&random);
  Eigen::VectorXd b = A.col(0);
  PersonPrior prior;
  prior.A = A;
  prior.x0 = x0;
  prior.b = b;
  CeresPersonPrior factor(2);
  factor.Set(&prior);
  // At x0 the residual is b; one unit along x(7) adds A's column 7.
  Blocks at = {x0.head(6), x0.tail(6)};
  EXPECT_EQ(Evaluate(factor, at).residuals, b);
  at[1](1) += 1.0;
  // Rounding of x0 + 1 - x0.
  EXPECT_LT((Evaluate(factor, at).residuals - b - A.col(7)).norm(), 1e-14);
  const ceres::AutoDiffCostFunction<MarginalTwin, 12, 6, 6> twin(
      new MarginalTwin{A, x0, b});
  ExpectSoundJacobians(factor, twin,
                       {RandomState(&random), RandomState(&random)});
  // Zero where A (x - x0) + b vanishes: at x0 with b = 0.
  prior.b.setZero();
  EXPECT_TRUE(Evaluate(factor, {x0.head(6), x0.tail(6)}).residuals.isZero(0.0));
}

}  // namespace
}  // namespace kinegraph
