#include "solvers/graph/linear_chain.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kinegraph {
namespace {

template <int N>
using Block = Eigen::Matrix<double, N, N>;
template <int N>
using Vector = Eigen::Matrix<double, N, 1>;

// Q(dt)^-1 and F(dt) of one axis; D is the number of derivatives in a state.
template <int D>
struct MotionInformation;

// constant_velocity_factor.h:
//   1/q [12/dt^3, -6/dt^2; -6/dt^2, 4/dt].
template <>
struct MotionInformation<2> {
  MotionInformation(double dt_s, double q) {
    const double pp = 12.0 / (q * dt_s * dt_s * dt_s);
    const double pv = 6.0 / (q * dt_s * dt_s);
    const double vv = 4.0 / (q * dt_s);
    inverse << pp, -pv, -pv, vv;
    advance << 1.0, dt_s, 0.0, 1.0;
  }
  Eigen::Matrix2d inverse;
  Eigen::Matrix2d advance;
};

// constant_acceleration_factor.h:
//   1/q [720/dt^5, -360/dt^4, 60/dt^3; ., 192/dt^3, -36/dt^2; ., ., 9/dt].
template <>
struct MotionInformation<3> {
  MotionInformation(double dt_s, double q) {
    const double h = 1.0 / dt_s;
    inverse << 720.0 * h * h * h * h, -360.0 * h * h * h, 60.0 * h * h,
        -360.0 * h * h * h, 192.0 * h * h, -36.0 * h,  //
        60.0 * h * h, -36.0 * h, 9.0;
    inverse *= h / q;
    advance << 1.0, dt_s, 0.5 * dt_s * dt_s,  //
        0.0, 1.0, dt_s,                       //
        0.0, 0.0, 1.0;
  }
  Eigen::Matrix3d inverse;
  Eigen::Matrix3d advance;
};

// Adds `axis`, each entry times the identity.
template <int D>
void AddPerAxis(const Eigen::Matrix<double, D, D>& axis, Block<3 * D>* block) {
  for (int row = 0; row < D; ++row) {
    for (int column = 0; column < D; ++column) {
      for (int i = 0; i < 3; ++i) {
        (*block)(3 * row + i, 3 * column + i) += axis(row, column);
      }
    }
  }
}

// With e = F x0 - x1: H00 = F' Q^-1 F, H11 = Q^-1.
template <int D>
void AddMotionInformation(const MotionInformation<D>& motion,
                          Block<3 * D>* from, Block<3 * D>* to) {
  AddPerAxis<D>(motion.advance.transpose() * motion.inverse * motion.advance,
                from);
  AddPerAxis<D>(motion.inverse, to);
}

// Gradient of 0.5 e' Q^-1 e; returns that cost. A state's columns, read as a
// 3 x D matrix, are its derivatives.
template <int D>
double AddMotionGradient(const MotionInformation<D>& motion,
                         const Vector<3 * D>& from, const Vector<3 * D>& to,
                         Vector<3 * D>* gradient_from,
                         Vector<3 * D>* gradient_to) {
  using Derivatives = Eigen::Matrix<double, 3, D>;
  const Eigen::Map<const Derivatives> x0(from.data());
  const Eigen::Map<const Derivatives> x1(to.data());
  const Derivatives error = x0 * motion.advance.transpose() - x1;
  const Derivatives pull = error * motion.inverse;
  Eigen::Map<Derivatives>(gradient_from->data()).noalias() +=
      pull * motion.advance;
  Eigen::Map<Derivatives>(gradient_to->data()) -= pull;
  return 0.5 * error.cwiseProduct(pull).sum();
}

// Adds scale * J'J of an observation with `by_point` = d px / d point.
template <int N>
void AddPixelInformation(const Matrix23d& by_point, double scale,
                         double offset_s, Block<N>* block) {
  const Eigen::Matrix3d information =
      scale * (by_point.transpose().lazyProduct(by_point));
  block->template block<3, 3>(0, 0) += information;
  if (offset_s == 0.0) return;
  block->template block<3, 3>(0, 3) += offset_s * information;
  block->template block<3, 3>(3, 0) += offset_s * information;
  block->template block<3, 3>(3, 3) += offset_s * offset_s * information;
}

// A view's clock is off by far less than a frame: the velocity carries it.
template <int N>
Eigen::Vector3d PointOf(const Vector<N>& state, double offset_s) {
  if (offset_s == 0.0) return state.template head<3>();
  return state.template head<3>() + offset_s * state.template segment<3>(3);
}

template <int N>
void AddPrior(const JointChain& chain, const Vector<N>& state,
              LinearChainOf<N>* linear) {
  const StatePrior& prior = chain.prior;
  const State residual =
      prior.A * (state.template head<6>() - prior.x0) + prior.b;
  linear->cost += 0.5 * residual.squaredNorm();
  linear->gradient[0].template head<6>().noalias() +=
      prior.A.transpose() * residual;
  linear->diagonal[0].template topLeftCorner<6, 6>().noalias() +=
      prior.A.transpose() * prior.A;
  if constexpr (N == 9) {
    const double information = 1.0 / (chain.birth_acceleration_sigma_mps2 *
                                      chain.birth_acceleration_sigma_mps2);
    const Eigen::Vector3d acceleration = state.template tail<3>();
    linear->cost += 0.5 * information * acceleration.squaredNorm();
    linear->gradient[0].template tail<3>() += information * acceleration;
    linear->diagonal[0].diagonal().template tail<3>().array() += information;
  }
}

template <int N>
bool AddMeasurement(const PixelMeasurement& measurement, const Vector<N>& state,
                    const SolveStage& stage, Block<N>* block,
                    Vector<N>* gradient, double* weight, double* cost) {
  Matrix23d by_point;
  const std::optional<Eigen::Vector2d> image = measurement.camera->Project(
      PointOf<N>(state, measurement.offset_s), &by_point);
  if (!image.has_value()) return false;
  const double inverse_variance =
      1.0 / (measurement.sigma_px * measurement.sigma_px);
  const Eigen::Vector2d error = *image - measurement.px;
  const LossValue loss = EvaluateLoss(stage.loss, stage.scale,
                                      error.squaredNorm() * inverse_variance);
  *weight = loss.first;
  *cost += 0.5 * measurement.information * loss.rho;
  const double scale = measurement.information * loss.first * inverse_variance;
  AddPixelInformation<N>(by_point, scale, measurement.offset_s, block);
  const Eigen::Vector3d pull = scale * (by_point.transpose() * error);
  gradient->template head<3>() += pull;
  if (measurement.offset_s != 0.0) {
    gradient->template segment<3>(3) += measurement.offset_s * pull;
  }
  return true;
}

}  // namespace

template <int N>
void LinearChainOf<N>::Resize(size_t frames, size_t measurements) {
  diagonal.resize(frames);
  upper.resize(frames > 0 ? frames - 1 : 0);
  gradient.resize(frames);
  weights.resize(measurements);
}

template <int N>
void LineariseMotion(const std::vector<TimeNs>& times, double process_noise,
                     LinearChainOf<N>* linear) {
  constexpr int kD = N / 3;
  linear->upper.resize(times.empty() ? 0 : times.size() - 1);
  for (size_t k = 0; k + 1 < times.size(); ++k) {
    const MotionInformation<kD> motion(ToSeconds(times[k + 1] - times[k]),
                                       process_noise);
    linear->upper[k].setZero();
    // H01 = -F' Q^-1.
    AddPerAxis<kD>(-motion.advance.transpose() * motion.inverse,
                   &linear->upper[k]);
  }
}

template <int N>
bool Linearise(const std::vector<TimeNs>& times, const JointChain& chain,
               const std::vector<Eigen::Matrix<double, N, 1>>& states,
               const SolveStage& stage, bool use_prior,
               LinearChainOf<N>* linear) {
  constexpr int kD = N / 3;
  linear->Resize(states.size(), chain.measurements.size());
  linear->cost = 0.0;
  for (Block<N>& block : linear->diagonal) block.setZero();
  for (Vector<N>& gradient : linear->gradient) gradient.setZero();
  if (use_prior) AddPrior<N>(chain, states[0], linear);
  for (size_t k = 0; k < states.size(); ++k) {
    if (k + 1 < states.size()) {
      const MotionInformation<kD> motion(ToSeconds(times[k + 1] - times[k]),
                                         chain.process_noise);
      AddMotionInformation<kD>(motion, &linear->diagonal[k],
                               &linear->diagonal[k + 1]);
      linear->cost +=
          AddMotionGradient<kD>(motion, states[k], states[k + 1],
                                &linear->gradient[k], &linear->gradient[k + 1]);
    }
    for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
      linear->weights[m] = 0.0;
      if (chain.measurements[m].gated) continue;
      if (!AddMeasurement<N>(chain.measurements[m], states[k], stage,
                             &linear->diagonal[k], &linear->gradient[k],
                             &linear->weights[m], &linear->cost)) {
        return false;
      }
    }
  }
  return std::isfinite(linear->cost);
}

template <int N>
void LineariseInformation(const std::vector<TimeNs>& times,
                          const JointChain& chain, double correction,
                          bool use_prior, LinearChainOf<N>* linear) {
  constexpr int kD = N / 3;
  linear->Resize(times.size(), chain.measurements.size());
  for (Block<N>& block : linear->diagonal) block.setZero();
  if (use_prior) {
    linear->diagonal[0].template topLeftCorner<6, 6>().noalias() +=
        chain.prior.A_stated.transpose() * chain.prior.A_stated;
    if constexpr (N == 9) {
      linear->diagonal[0].diagonal().template tail<3>().array() +=
          1.0 / (chain.birth_acceleration_sigma_mps2 *
                 chain.birth_acceleration_sigma_mps2);
    }
  }
  for (size_t k = 0; k < times.size(); ++k) {
    if (k + 1 < times.size()) {
      AddMotionInformation<kD>(
          MotionInformation<kD>(ToSeconds(times[k + 1] - times[k]),
                                chain.process_noise),
          &linear->diagonal[k], &linear->diagonal[k + 1]);
    }
    for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
      const PixelMeasurement& measurement = chain.measurements[m];
      if (measurement.gated || measurement.weight <= 0.0) continue;
      Matrix23d by_point;
      const bool visible =
          measurement.camera
              ->Project(
                  PointOf<kStateSize>(chain.states[k], measurement.offset_s),
                  &by_point)
              .has_value();
      if (!visible) continue;
      AddPixelInformation<N>(by_point,
                             correction * measurement.information *
                                 measurement.weight /
                                 (measurement.sigma_px * measurement.sigma_px),
                             measurement.offset_s, &linear->diagonal[k]);
    }
  }
}

#define KINEGRAPH_INSTANTIATE(N)                                              \
  template struct LinearChainOf<N>;                                           \
  template void LineariseMotion<N>(const std::vector<TimeNs>&, double,        \
                                   LinearChainOf<N>*);                        \
  template bool Linearise<N>(const std::vector<TimeNs>&, const JointChain&,   \
                             const std::vector<Eigen::Matrix<double, N, 1>>&, \
                             const SolveStage&, bool, LinearChainOf<N>*);     \
  template void LineariseInformation<N>(const std::vector<TimeNs>&,           \
                                        const JointChain&, double, bool,      \
                                        LinearChainOf<N>*);
KINEGRAPH_INSTANTIATE(6)
KINEGRAPH_INSTANTIATE(9)
#undef KINEGRAPH_INSTANTIATE

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
