#include "solvers/graph/marginalise_frame.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <optional>
#include <vector>

#include "solvers/factors/bone_length_factor.h"
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

namespace {

// Everything a joint's first state was measured by, whitened, as six rows.
void CompressMeasurements(const JointChain& chain, Rows* rows) {
  rows->jacobian.setZero(kStateSize + 2 * CountMeasured(chain), kStateSize);
  rows->residual.setZero(rows->jacobian.rows());
  int row = kStateSize;  // six rows of zeros, so that there are enough
  for (int32_t m = 0; m < chain.first[1]; ++m) {
    if (chain.measurements[m].gated) continue;
    AddMeasurement(chain.measurements[m], chain.states[0], 1.0, row, rows);
    row += 2;
  }
  const SquareRootPrior square = Marginalise(rows->jacobian, rows->residual, 0);
  rows->jacobian = square.A;
  rows->residual = square.b;
}

// The prior on all first states, as rows above each other.
void AddPriors(const PersonProblem& problem, Rows* rows) {
  const Eigen::Index size = rows->jacobian.cols();
  if (problem.prior.empty()) {
    for (size_t j = 0; j < problem.joints.size(); ++j) {
      const StatePrior& prior = problem.joints[j].prior;
      rows->jacobian.block<6, 6>(6 * j, 6 * j) = prior.A;
      rows->residual.segment<6>(6 * j) =
          prior.A * (problem.joints[j].states[0] - prior.x0) + prior.b;
    }
    return;
  }
  Eigen::VectorXd away = -problem.prior.x0;
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    away.segment<6>(6 * j) += problem.joints[j].states[0];
  }
  rows->jacobian.topRows(size) = problem.prior.A;
  rows->residual.head(size) = problem.prior.A * away + problem.prior.b;
}

void AddBoneRow(const PersonProblem& problem, const BoneConstraint& bone,
                Eigen::Index row, Rows* rows) {
  const BoneLengthFactor factor(bone.length_m, bone.sigma_m);
  const double* states[] = {problem.joints[bone.a].states[0].data(),
                            problem.joints[bone.b].states[0].data()};
  State by_a;
  State by_b;
  double* jacobians[] = {by_a.data(), by_b.data()};
  factor.Evaluate(states, &rows->residual(row), jacobians);
  rows->jacobian.block<1, 6>(row, 6 * bone.a) = by_a.transpose();
  rows->jacobian.block<1, 6>(row, 6 * bone.b) = by_b.transpose();
}

// Square root of the information that the dropped frame leaves for what is
// stated, by Schur complement: less exact than the QR of the estimate's own
// prior, in a fraction of its time. nullopt when it is not definite.
std::optional<Eigen::MatrixXd> StatedInformation(const PersonProblem& problem,
                                                 double correction) {
  const auto joint_count = static_cast<Eigen::Index>(problem.joints.size());
  const Eigen::Index size = kStateSize * joint_count;
  Eigen::MatrixXd first = Eigen::MatrixXd::Zero(size, size);
  if (!problem.prior.empty()) {
    first.noalias() =
        problem.prior.A_stated.transpose() * problem.prior.A_stated;
  }
  Rows bone{Eigen::MatrixXd::Zero(1, size), Eigen::VectorXd::Zero(1)};
  for (const BoneConstraint& constraint : problem.bones) {
    bone.jacobian.setZero();
    AddBoneRow(problem, constraint, 0, &bone);
    first.noalias() += bone.jacobian.transpose() * bone.jacobian;
  }
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd second = Eigen::MatrixXd::Zero(size, size);
  Rows motion{Eigen::MatrixXd::Zero(12, 12), Eigen::VectorXd::Zero(12)};
  const double dt_s = ToSeconds(problem.times[1] - problem.times[0]);
  for (Eigen::Index j = 0; j < joint_count; ++j) {
    const JointChain& chain = problem.joints[j];
    auto own = first.block<6, 6>(6 * j, 6 * j);
    if (problem.prior.empty()) {
      own += chain.prior.A_stated.transpose() * chain.prior.A_stated;
    }
    for (int32_t m = 0; m < chain.first[1]; ++m) {
      if (chain.measurements[m].gated) continue;
      Rows pixel{Eigen::MatrixXd::Zero(2, 6), Eigen::VectorXd::Zero(2)};
      AddMeasurement(chain.measurements[m], chain.states[0], correction, 0,
                     &pixel);
      own += pixel.jacobian.transpose() * pixel.jacobian;
    }
    AddMotion(dt_s, chain, &motion);
    const auto by_first = motion.jacobian.block<6, 6>(6, 0);
    const auto by_second = motion.jacobian.block<6, 6>(6, 6);
    own += by_first.transpose() * by_first;
    coupling.block<6, 6>(6 * j, 6 * j) = by_first.transpose() * by_second;
    second.block<6, 6>(6 * j, 6 * j) = by_second.transpose() * by_second;
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> eliminated(first);
  if (eliminated.info() != Eigen::Success) return std::nullopt;
  eliminated.matrixL().solveInPlace(coupling);
  second.selfadjointView<Eigen::Lower>().rankUpdate(coupling.transpose(), -1.0);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> kept(second);
  if (kept.info() != Eigen::Success) return std::nullopt;
  return Eigen::MatrixXd(kept.matrixU());
}

}  // namespace

PersonPrior MarginaliseFirstFrame(const PersonProblem& problem,
                                  double correction) {
  const auto joint_count = static_cast<Eigen::Index>(problem.joints.size());
  const auto bone_count = static_cast<Eigen::Index>(problem.bones.size());
  const Eigen::Index size = kStateSize * joint_count;
  // First the factors on the first states alone, then the motion: smaller
  // factorisations than one of everything.
  Rows first{Eigen::MatrixXd::Zero(2 * size + bone_count, size),
             Eigen::VectorXd::Zero(2 * size + bone_count)};
  AddPriors(problem, &first);
  Rows joint;
  for (Eigen::Index j = 0; j < joint_count; ++j) {
    CompressMeasurements(problem.joints[j], &joint);
    first.jacobian.block<6, 6>(size + 6 * j, 6 * j) = joint.jacobian;
    first.residual.segment<6>(size + 6 * j) = joint.residual;
  }
  for (Eigen::Index i = 0; i < bone_count; ++i) {
    AddBoneRow(problem, problem.bones[i], 2 * size + i, &first);
  }
  const SquareRootPrior reduced =
      Marginalise(first.jacobian, first.residual, 0);

  Rows both{Eigen::MatrixXd::Zero(2 * size, 2 * size),
            Eigen::VectorXd::Zero(2 * size)};
  both.jacobian.topLeftCorner(size, size) = reduced.A;
  both.residual.head(size) = reduced.b;
  Rows motion{Eigen::MatrixXd::Zero(12, 12), Eigen::VectorXd::Zero(12)};
  const double dt_s = ToSeconds(problem.times[1] - problem.times[0]);
  PersonPrior prior;
  prior.x0.resize(size);
  for (Eigen::Index j = 0; j < joint_count; ++j) {
    AddMotion(dt_s, problem.joints[j], &motion);
    both.jacobian.block<6, 6>(size + 6 * j, 6 * j) =
        motion.jacobian.block<6, 6>(6, 0);
    both.jacobian.block<6, 6>(size + 6 * j, size + 6 * j) =
        motion.jacobian.block<6, 6>(6, 6);
    both.residual.segment<6>(size + 6 * j) = motion.residual.tail<6>();
    prior.x0.segment<6>(6 * j) = problem.joints[j].states[1];
  }
  const SquareRootPrior kept =
      Marginalise(both.jacobian, both.residual, static_cast<int>(size));
  prior.A = kept.A;
  prior.b = kept.b;
  prior.A_stated = prior.A;
  if (correction != 1.0) {
    const std::optional<Eigen::MatrixXd> stated =
        StatedInformation(problem, correction);
    if (stated.has_value()) prior.A_stated = *stated;
  }
  return prior;
}

void DropFirstFrame(double correction, PersonProblem* problem) {
  if (!problem->bones.empty() || !problem->prior.empty()) {
    problem->prior = MarginaliseFirstFrame(*problem, correction);
  }
  for (JointChain& chain : problem->joints) {
    chain.prior = MarginaliseFirstState(problem->times, chain, correction);
    EraseFirst(&chain);
  }
  problem->times.erase(problem->times.begin());
}

}  // namespace kinegraph
