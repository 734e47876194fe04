#include "solvers/graph/marginalise_frame.h"

#include <glog/logging.h>

#include <cmath>
#include <vector>

#include "solvers/factors/constant_velocity_factor.h"
#include "solvers/factors/reprojection_factor.h"
#include "solvers/graph/marginalise.h"

namespace kinegraph {
namespace {

template <int Rows>
using Rows6 = Eigen::Matrix<double, Rows, kStateSize, Eigen::RowMajor>;

// Whitened, linearised rows over [first state, second state].
struct Rows {
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd residual;
};

int CountMeasured(const JointChain& chain) {
  int count = 0;
  for (int32_t m = 0; m < chain.first[1]; ++m) {
    if (!chain.measurements[m].gated) ++count;
  }
  return count;
}

void AddMotion(double dt_s, const JointChain& chain, Rows* rows) {
  const ConstantVelocityFactor factor(dt_s, chain.process_noise);
  const double* states[] = {chain.states[0].data(), chain.states[1].data()};
  State residual;
  Rows6<6> by_first;
  Rows6<6> by_second;
  double* jacobians[] = {by_first.data(), by_second.data()};
  factor.Evaluate(states, residual.data(), jacobians);
  rows->jacobian.block<6, 6>(6, 0) = by_first;
  rows->jacobian.block<6, 6>(6, 6) = by_second;
  rows->residual.segment<6>(6) = residual;
}

void AddMeasurement(const PixelMeasurement& measurement, const State& state,
                    double correction, int row, Rows* rows) {
  const ReprojectionFactor factor(measurement.camera, measurement.px,
                                  measurement.sigma_px, measurement.offset_s);
  const double* states[] = {state.data()};
  Eigen::Vector2d residual;
  Rows6<2> jacobian;
  double* jacobians[] = {jacobian.data()};
  if (!factor.Evaluate(states, residual.data(), jacobians)) return;
  const double root =
      std::sqrt(correction * measurement.information * measurement.weight);
  rows->jacobian.block<2, 6>(row, 0) = root * jacobian;
  rows->residual.segment<2>(row) = root * residual;
}

SquareRootPrior MarginaliseWith(const std::vector<TimeNs>& times,
                                const JointChain& chain, const Matrix6d& A,
                                double correction) {
  const int row_count = 12 + 2 * CountMeasured(chain);
  Rows rows{Eigen::MatrixXd::Zero(row_count, 12),
            Eigen::VectorXd::Zero(row_count)};
  const StatePrior& prior = chain.prior;
  rows.jacobian.block<6, 6>(0, 0) = A;
  rows.residual.head<6>() = A * (chain.states[0] - prior.x0) + prior.b;
  AddMotion(ToSeconds(times[1] - times[0]), chain, &rows);
  int row = 12;
  for (int32_t m = 0; m < chain.first[1]; ++m) {
    if (chain.measurements[m].gated) continue;
    AddMeasurement(chain.measurements[m], chain.states[0], correction, row,
                   &rows);
    row += 2;
  }
  return Marginalise(rows.jacobian, rows.residual, kStateSize);
}

void EraseFirst(JointChain* chain) {
  const int32_t dropped = chain->first[1];
  chain->measurements.erase(chain->measurements.begin(),
                            chain->measurements.begin() + dropped);
  chain->first.erase(chain->first.begin());
  for (int32_t& first : chain->first) first -= dropped;
  chain->states.erase(chain->states.begin());
}

}  // namespace

StatePrior MarginaliseFirstState(const std::vector<TimeNs>& times,
                                 const JointChain& chain, double correction) {
  CHECK_GE(chain.states.size(), 2u);
  const SquareRootPrior kept =
      MarginaliseWith(times, chain, chain.prior.A, 1.0);
  StatePrior prior;
  prior.A = kept.A;
  prior.b = kept.b;
  prior.x0 = chain.states[1];
  prior.A_stated =
      correction == 1.0
          ? prior.A
          : Matrix6d(
                MarginaliseWith(times, chain, chain.prior.A_stated, correction)
                    .A);
  return prior;
}

void DropFirstFrame(double correction, PersonProblem* problem) {
  for (JointChain& chain : problem->joints) {
    chain.prior = MarginaliseFirstState(problem->times, chain, correction);
    EraseFirst(&chain);
  }
  problem->times.erase(problem->times.begin());
}

}  // namespace kinegraph
