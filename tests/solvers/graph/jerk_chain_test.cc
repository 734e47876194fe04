// A chain with white noise on jerk: the same solver with states of nine.
#include <ceres/normal_prior.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <memory>
#include <vector>

#include "core/base/error.h"
#include "solvers/batch/batch_estimator.h"
#include "solvers/factors/ceres_loss.h"
#include "solvers/factors/constant_acceleration_factor.h"
#include "solvers/factors/marginal_prior_factor.h"
#include "solvers/factors/reprojection_factor.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/chain_solver.h"
#include "solvers/window/window_estimator.h"
#include "tests/support/simulated_person.h"

namespace kinegraph {
namespace {

using testing::SimulatedNoise;
using testing::SimulatedTake;

// A factor on a state of six as one on the first six of nine.
class OnFirstSix final : public ceres::CostFunction {
 public:
  explicit OnFirstSix(ceres::CostFunction* inner) : inner_(inner) {
    set_num_residuals(inner->num_residuals());
    mutable_parameter_block_sizes()->push_back(kJerkStateSize);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    if (jacobians == nullptr || jacobians[0] == nullptr) {
      return inner_->Evaluate(parameters, residuals, nullptr);
    }
    const int rows = num_residuals();
    std::vector<double> inner(static_cast<size_t>(rows) * kStateSize);
    double* blocks[] = {inner.data()};
    if (!inner_->Evaluate(parameters, residuals, blocks)) return false;
    for (int row = 0; row < rows; ++row) {
      for (int i = 0; i < kJerkStateSize; ++i) {
        jacobians[0][row * kJerkStateSize + i] =
            i < kStateSize ? inner[row * kStateSize + i] : 0.0;
      }
    }
    return true;
  }

 private:
  std::unique_ptr<ceres::CostFunction> inner_;
};

class JerkChainTest : public ::testing::Test {
 protected:
  void Make(int cameras, int frames, const SimulatedNoise& noise) {
    options_.motion = MotionPrior::kJerk;
    scene_.cameras = testing::RingOfCameras(cameras, 5.0, 1000.0, true);
    scene_.skeleton = testing::SmallSkeleton();
    scene_.frame_rate_hz = 25.0;
    Random random(23);
    take_ = testing::Simulate(scene_, GraphOptions(),
                              testing::WalkingMotion(scene_, frames), noise,
                              Eigen::Vector3d::Zero(), &random);
    Assembler assembler(scene_, options_);
    problem_ = assembler.EmptyProblem();
    for (EstimatorFrame& frame : take_.frames) {
      for (FreshView& view : frame.views) {
        view.capture_time += view.view_idx * 2'000'000;  // a little late
      }
      assembler.Append(frame, &problem_);
    }
    for (JointChain& chain : problem_.joints) GateMeasurements(&chain);
  }

  SceneModel scene_;
  GraphOptions options_;
  SimulatedTake take_;
  PersonProblem problem_;
};

SolveSchedule Exact(LossKind loss) {
  SolveSchedule schedule;
  schedule.step_tolerance_m = 1e-11;
  schedule.stages = {{LossKind::kHuber, 1.5, 300}, {loss, 3.0, 300}};
  return schedule;
}

// The chain's minimum near where it is, found by Ceres with our factors.
std::vector<JerkState> ByCeres(const std::vector<TimeNs>& times,
                               const JointChain& chain, LossKind loss) {
  std::vector<JerkState> states(chain.states.size());
  for (size_t k = 0; k < states.size(); ++k) {
    states[k] << chain.states[k], chain.accelerations[k];
  }
  ceres::Problem problem;
  const StatePrior& prior = chain.prior;
  problem.AddResidualBlock(
      new OnFirstSix(MarginalPriorFactor::Create(prior.A, prior.x0, prior.b)),
      nullptr, states[0].data());
  ceres::Matrix on_acceleration = ceres::Matrix::Zero(3, kJerkStateSize);
  on_acceleration.rightCols(3).diagonal().setConstant(
      1.0 / chain.birth_acceleration_sigma_mps2);
  problem.AddResidualBlock(
      new ceres::NormalPrior(on_acceleration,
                             ceres::Vector::Zero(kJerkStateSize)),
      nullptr, states[0].data());
  for (size_t k = 0; k < states.size(); ++k) {
    if (k + 1 < states.size()) {
      problem.AddResidualBlock(
          ConstantAccelerationFactor::Create(ToSeconds(times[k + 1] - times[k]),
                                             chain.process_noise),
          nullptr, states[k].data(), states[k + 1].data());
    }
    for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
      const PixelMeasurement& measurement = chain.measurements[m];
      if (measurement.gated) continue;
      problem.AddResidualBlock(
          new OnFirstSix(ReprojectionFactor::Create(
              measurement.camera, measurement.px, measurement.sigma_px,
              measurement.offset_s)),
          MakeCeresLoss(loss, 3.0, measurement.information), states[k].data());
    }
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 300;
  options.parameter_tolerance = 1e-13;
  options.function_tolerance = 1e-22;
  options.gradient_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return states;
}

TEST_F(JerkChainTest, FindsTheMinimumOfTheFactors) {
  SimulatedNoise noise;
  noise.outliers = 0.1;
  noise.missing = 0.1;
  Make(5, 40, noise);
  for (const LossKind loss :
       {LossKind::kNone, LossKind::kHuber, LossKind::kGemanMcClure}) {
    JointChain chain = problem_.joints[0];
    JerkChainSolver solver;
    EXPECT_TRUE(solver.Solve(problem_.times, Exact(loss), &chain).finite);
    const std::vector<JerkState> ceres = ByCeres(problem_.times, chain, loss);
    for (size_t k = 0; k < ceres.size(); ++k) {
      // Ceres stops where rounding hides the cost's progress
      // (chain_solver_test.cc).
      EXPECT_LT((ceres[k].head<3>() - chain.states[k].head<3>()).norm(), 1e-7);
    }
  }
}

TEST_F(JerkChainTest, CovariancesAreBlocksOfTheDenseInverse) {
  SimulatedNoise noise;
  noise.missing = 0.3;
  Make(3, 25, noise);
  JointChain& chain = problem_.joints[0];
  JerkChainSolver solver;
  solver.Solve(problem_.times, Exact(LossKind::kGemanMcClure), &chain);
  std::vector<Matrix6d> covariances;
  ASSERT_TRUE(solver.Covariances(problem_.times, chain, 1.1, &covariances));
  LinearChainOf<9> linear;
  LineariseMotion<9>(problem_.times, chain.process_noise, &linear);
  LineariseInformation<9>(problem_.times, chain, 1.1, true, &linear);
  const auto count = static_cast<Eigen::Index>(chain.states.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(9 * count, 9 * count);
  for (Eigen::Index k = 0; k < count; ++k) {
    information.block<9, 9>(9 * k, 9 * k) = linear.diagonal[k];
    if (k + 1 == count) break;
    information.block<9, 9>(9 * k, 9 * k + 9) = linear.upper[k];
    information.block<9, 9>(9 * k + 9, 9 * k) = linear.upper[k].transpose();
  }
  const Eigen::MatrixXd dense = information.inverse();
  for (Eigen::Index k = 0; k < count; ++k) {
    const Matrix6d expected = dense.block<6, 6>(9 * k, 9 * k);
    // The information spans dt^-5 .. 1, some ten digits of the sixteen.
    EXPECT_LT((covariances[k] - expected).norm(), 1e-5 * expected.norm()) << k;
  }
}

// Free fall has no jerk at all: seen exactly, it is found exactly, also where
// half a second of it is hidden.
TEST_F(JerkChainTest, ThrowsAreBridged) {
  options_.birth_position_sigma_m = 1e3;
  options_.birth_velocity_sigma_mps = 1e3;
  options_.birth_acceleration_sigma_mps2 = 1e4;
  Make(4, 40, SimulatedNoise());
  std::vector<Eigen::Vector3d> truth;
  for (size_t k = 0; k < 40; ++k) {
    const double t = 0.04 * static_cast<double>(k);
    truth.emplace_back(0.5 * t, 0.2, 1.0 + 3.0 * t - 0.5 * 9.81 * t * t);
  }
  JointChain chain = problem_.joints[0];
  for (size_t k = 0; k < 40; ++k) {
    for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
      PixelMeasurement& measurement = chain.measurements[m];
      measurement.offset_s = 0.0;
      measurement.gated = k >= 14 && k < 27;
      const auto image = measurement.camera->Project(truth[k]);
      ASSERT_TRUE(image.has_value());
      measurement.px = *image;
    }
    chain.states[k].head<3>() = truth[20];
  }
  JerkChainSolver solver;
  EXPECT_TRUE(
      solver.Solve(problem_.times, Exact(LossKind::kNone), &chain).converged);
  for (size_t k = 0; k < 40; ++k) {
    // Birth priors as wide as these pull by micrometres at most: their
    // information is below 1e-6 / m^2, a view's above 1e2 / m^2.
    EXPECT_LT((chain.states[k].head<3>() - truth[k]).norm(), 1e-5) << k;
    EXPECT_NEAR(chain.accelerations[k].z(), -9.81, 1e-2) << k;
  }
}

TEST_F(JerkChainTest, BatchTakesItWindowsAndBonesDoNot) {
  Make(4, 30, SimulatedNoise());
  const auto batch = MakeBatchEstimator(scene_, options_);
  EXPECT_LT(testing::RootMeanSquare(take_.truth,
                                    testing::Run(batch.get(), take_.frames)),
            0.05);
  EXPECT_THROW(MakeWindowEstimator(scene_, options_), OptionError);
  options_.bones = true;
  EXPECT_THROW(MakeBatchEstimator(scene_, options_), OptionError);
}

}  // namespace
}  // namespace kinegraph
