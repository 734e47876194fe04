#include "solvers/graph/linear_chain.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kinegraph {
namespace {

// Q(dt)^-1 of constant_velocity_factor.h, one axis:
//   [pp, -pv; -pv, vv] = 1/q [12/dt^3, -6/dt^2; -6/dt^2, 4/dt].
struct MotionInformation {
  MotionInformation(TimeNs from, TimeNs to, double q)
      : dt_s(ToSeconds(to - from)),
        pp(12.0 / (q * dt_s * dt_s * dt_s)),
        pv(6.0 / (q * dt_s * dt_s)),
        vv(4.0 / (q * dt_s)) {}
  double dt_s;
  double pp;
  double pv;
  double vv;
};

// Adds the 2x2 matrix [pp pv; vp vv], each entry times the identity.
void AddPerAxis(double pp, double pv, double vp, double vv, Matrix6d* block) {
  for (int axis = 0; axis < 3; ++axis) {
    (*block)(axis, axis) += pp;
    (*block)(axis, axis + 3) += pv;
    (*block)(axis + 3, axis) += vp;
    (*block)(axis + 3, axis + 3) += vv;
  }
}

// With e = F x0 - x1, F = [1 dt; 0 1]: H00 = F' Q^-1 F, H11 = Q^-1.
void AddMotionInformation(const MotionInformation& motion, Matrix6d* from,
                          Matrix6d* to) {
  AddPerAxis(motion.pp, motion.pv, motion.pv, motion.vv, from);
  AddPerAxis(motion.pp, -motion.pv, -motion.pv, motion.vv, to);
}

// Gradient of 0.5 e' Q^-1 e; returns that cost.
double AddMotionGradient(const MotionInformation& motion, const State& from,
                         const State& to, State* gradient_from,
                         State* gradient_to) {
  const Eigen::Vector3d ep =
      from.head<3>() + motion.dt_s * from.tail<3>() - to.head<3>();
  const Eigen::Vector3d ev = from.tail<3>() - to.tail<3>();
  const Eigen::Vector3d gp = motion.pp * ep - motion.pv * ev;
  const Eigen::Vector3d gv = motion.vv * ev - motion.pv * ep;
  gradient_from->head<3>() += gp;
  gradient_from->tail<3>() += motion.dt_s * gp + gv;
  gradient_to->head<3>() -= gp;
  gradient_to->tail<3>() -= gv;
  return 0.5 * (ep.dot(gp) + ev.dot(gv));
}

// Adds scale * J'J of an observation with `by_point` = d px / d point.
void AddPixelInformation(const Matrix23d& by_point, double scale,
                         double offset_s, Matrix6d* block) {
  const Eigen::Matrix3d information =
      scale * (by_point.transpose().lazyProduct(by_point));
  block->topLeftCorner<3, 3>() += information;
  if (offset_s == 0.0) return;
  block->topRightCorner<3, 3>() += offset_s * information;
  block->bottomLeftCorner<3, 3>() += offset_s * information;
  block->bottomRightCorner<3, 3>() += offset_s * offset_s * information;
}

Eigen::Vector3d PointOf(const State& state, double offset_s) {
  if (offset_s == 0.0) return state.head<3>();
  return state.head<3>() + offset_s * state.tail<3>();
}

void AddPrior(const StatePrior& prior, const State& state,
              LinearChain* linear) {
  const State residual = prior.A * (state - prior.x0) + prior.b;
  linear->cost += 0.5 * residual.squaredNorm();
  linear->gradient[0].noalias() += prior.A.transpose() * residual;
  linear->diagonal[0].noalias() += prior.A.transpose() * prior.A;
}

bool AddMeasurement(const PixelMeasurement& measurement, const State& state,
                    const SolveStage& stage, Matrix6d* block, State* gradient,
                    double* weight, double* cost) {
  Matrix23d by_point;
  const std::optional<Eigen::Vector2d> image = measurement.camera->Project(
      PointOf(state, measurement.offset_s), &by_point);
  if (!image.has_value()) return false;
  const double inverse_variance =
      1.0 / (measurement.sigma_px * measurement.sigma_px);
  const Eigen::Vector2d error = *image - measurement.px;
  const LossValue loss = EvaluateLoss(stage.loss, stage.scale,
                                      error.squaredNorm() * inverse_variance);
  *weight = loss.first;
  *cost += 0.5 * measurement.information * loss.rho;
  const double scale = measurement.information * loss.first * inverse_variance;
  AddPixelInformation(by_point, scale, measurement.offset_s, block);
  const Eigen::Vector3d pull = scale * (by_point.transpose() * error);
  gradient->head<3>() += pull;
  if (measurement.offset_s != 0.0) {
    gradient->tail<3>() += measurement.offset_s * pull;
  }
  return true;
}

}  // namespace

void LinearChain::Resize(size_t frames, size_t measurements) {
  diagonal.resize(frames);
  upper.resize(frames > 0 ? frames - 1 : 0);
  gradient.resize(frames);
  weights.resize(measurements);
}

void LineariseMotion(const std::vector<TimeNs>& times, double process_noise,
                     LinearChain* linear) {
  linear->upper.resize(times.empty() ? 0 : times.size() - 1);
  for (size_t k = 0; k + 1 < times.size(); ++k) {
    const MotionInformation motion(times[k], times[k + 1], process_noise);
    linear->upper[k].setZero();
    // H01 = -F' Q^-1; its last entry is -(vv - dt pv) = vv / 2.
    AddPerAxis(-motion.pp, motion.pv, -motion.pv, 0.5 * motion.vv,
               &linear->upper[k]);
  }
}

bool Linearise(const std::vector<TimeNs>& times, const JointChain& chain,
               const std::vector<State>& states, const SolveStage& stage,
               bool use_prior, LinearChain* linear) {
  linear->Resize(states.size(), chain.measurements.size());
  linear->cost = 0.0;
  for (Matrix6d& block : linear->diagonal) block.setZero();
  for (State& gradient : linear->gradient) gradient.setZero();
  if (use_prior) AddPrior(chain.prior, states[0], linear);
  for (size_t k = 0; k < states.size(); ++k) {
    if (k + 1 < states.size()) {
      const MotionInformation motion(times[k], times[k + 1],
                                     chain.process_noise);
      AddMotionInformation(motion, &linear->diagonal[k],
                           &linear->diagonal[k + 1]);
      linear->cost +=
          AddMotionGradient(motion, states[k], states[k + 1],
                            &linear->gradient[k], &linear->gradient[k + 1]);
    }
    for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
      linear->weights[m] = 0.0;
      if (chain.measurements[m].gated) continue;
      if (!AddMeasurement(chain.measurements[m], states[k], stage,
                          &linear->diagonal[k], &linear->gradient[k],
                          &linear->weights[m], &linear->cost)) {
        return false;
      }
    }
  }
  return std::isfinite(linear->cost);
}

void LineariseInformation(const std::vector<TimeNs>& times,
                          const JointChain& chain, double correction,
                          bool use_prior, LinearChain* linear) {
  linear->Resize(times.size(), chain.measurements.size());
  for (Matrix6d& block : linear->diagonal) block.setZero();
  if (use_prior) {
    linear->diagonal[0].noalias() +=
        chain.prior.A_stated.transpose() * chain.prior.A_stated;
  }
  for (size_t k = 0; k < times.size(); ++k) {
    if (k + 1 < times.size()) {
      AddMotionInformation(
          MotionInformation(times[k], times[k + 1], chain.process_noise),
          &linear->diagonal[k], &linear->diagonal[k + 1]);
    }
    for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
      const PixelMeasurement& measurement = chain.measurements[m];
      if (measurement.gated || measurement.weight <= 0.0) continue;
      Matrix23d by_point;
      const bool visible =
          measurement.camera
              ->Project(PointOf(chain.states[k], measurement.offset_s),
                        &by_point)
              .has_value();
      if (!visible) continue;
      AddPixelInformation(by_point,
                          correction * measurement.information *
                              measurement.weight /
                              (measurement.sigma_px * measurement.sigma_px),
                          measurement.offset_s, &linear->diagonal[k]);
    }
  }
}

int DoubtUnsettled(const std::vector<State>& step, const JointChain& chain,
                   std::vector<double>* weights) {
  constexpr double kUnsettled = 0.05;  // m
  int count = 0;
  for (size_t k = 0; k < step.size(); ++k) {
    // Written so that a move that is no number counts too.
    if (step[k].head<3>().cwiseAbs().maxCoeff() < kUnsettled) continue;
    ++count;
    std::fill(weights->begin() + chain.first[k],
              weights->begin() + chain.first[k + 1], 0.0);
  }
  return count;
}

}  // namespace kinegraph
