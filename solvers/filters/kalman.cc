#include "solvers/filters/kalman.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

// F(dt) and Q(dt) of one coordinate, derivatives x derivatives.
Eigen::MatrixXd TransitionMatrix(int derivatives, double dt_s) {
  Eigen::MatrixXd F = Eigen::MatrixXd::Identity(derivatives, derivatives);
  for (int i = 0; i + 1 < derivatives; ++i) F(i, i + 1) = dt_s;
  if (derivatives == 3) F(0, 2) = 0.5 * dt_s * dt_s;
  return F;
}

Eigen::MatrixXd ProcessNoise(int derivatives, double power, double dt_s) {
  const double dt2 = dt_s * dt_s;
  const double dt3 = dt2 * dt_s;
  if (derivatives == 2) {
    return power * Eigen::Matrix2d{{dt3 / 3.0, dt2 / 2.0}, {dt2 / 2.0, dt_s}};
  }
  return power * Eigen::Matrix3d{{dt2 * dt3 / 20.0, dt2 * dt2 / 8.0, dt3 / 6.0},
                                 {dt2 * dt2 / 8.0, dt3 / 3.0, dt2 / 2.0},
                                 {dt3 / 6.0, dt2 / 2.0, dt_s}};
}

// Three coordinates per derivative, position first.
template <int kSize>
struct Belief {
  Eigen::Matrix<double, kSize, 1> mean;
  Eigen::Matrix<double, kSize, kSize> covariance;
};

template <int kSize>
using StateMatrix = Eigen::Matrix<double, kSize, kSize>;

// Each entry of a matrix of one coordinate times a 3x3 identity.
template <int kSize>
StateMatrix<kSize> InSpace(const Eigen::MatrixXd& one) {
  StateMatrix<kSize> all = StateMatrix<kSize>::Zero();
  for (int r = 0; r < kSize / 3; ++r) {
    for (int c = 0; c < kSize / 3; ++c) {
      all.template block<3, 3>(3 * r, 3 * c).diagonal().setConstant(one(r, c));
    }
  }
  return all;
}

template <int kSize>
void Update(const Eigen::Vector3d& measured, const Eigen::Matrix3d& noise,
            Belief<kSize>* belief) {
  using State = Eigen::Matrix<double, kSize, 1>;
  StateMatrix<kSize>& P = belief->covariance;
  const Eigen::Matrix3d S = P.template topLeftCorner<3, 3>() + noise;
  // K = P H' S^-1; H picks the position.
  const Eigen::Matrix<double, kSize, 3> K =
      S.ldlt().solve(P.template topRows<3>()).transpose();
  const State gain = K * (measured - belief->mean.template head<3>());
  belief->mean += gain;
  StateMatrix<kSize> I_KH = StateMatrix<kSize>::Identity();
  I_KH.template leftCols<3>() -= K;
  P = (I_KH * P * I_KH.transpose() + K * noise * K.transpose()).eval();
}

// The filter's estimates at each time of a segment.
template <int kSize>
struct FilterRun {
  std::vector<Belief<kSize>> filtered;
  std::vector<Belief<kSize>> predicted;         // none at the first time
  std::vector<StateMatrix<kSize>> transitions;  // [k]: from time k - 1
};

template <int kSize>
Belief<kSize> FirstBelief(const JointSegment& segment) {
  Belief<kSize> belief;
  belief.mean.setZero();
  belief.mean.template head<3>() = segment.positions_m.row(0).transpose();
  belief.covariance.setZero();
  belief.covariance.template topLeftCorner<3, 3>() = segment.covariances_m2[0];
  for (int d = 1; d < kSize / 3; ++d) {
    const double sigma = PointModel::kStartSigmas[d - 1];
    belief.covariance.template block<3, 3>(3 * d, 3 * d)
        .diagonal()
        .setConstant(sigma * sigma);
  }
  return belief;
}

template <int kSize>
FilterRun<kSize> RunFilter(const PointModel& model,
                           const JointSegment& segment) {
  const size_t count = segment.times_s.size();
  FilterRun<kSize> run;
  run.filtered.resize(count);
  run.predicted.resize(count);
  run.transitions.resize(count);
  Belief<kSize> belief = FirstBelief<kSize>(segment);
  run.filtered[0] = belief;
  for (size_t k = 1; k < count; ++k) {
    const double dt_s = segment.times_s[k] - segment.times_s[k - 1];
    run.transitions[k] = InSpace<kSize>(TransitionMatrix(kSize / 3, dt_s));
    belief.mean = (run.transitions[k] * belief.mean).eval();
    belief.covariance =
        (run.transitions[k] * belief.covariance *
             run.transitions[k].transpose() +
         InSpace<kSize>(ProcessNoise(kSize / 3, model.power, dt_s)))
            .eval();
    run.predicted[k] = belief;
    if (segment.sampled[k]) {
      Update<kSize>(
          segment.positions_m.row(static_cast<Eigen::Index>(k)).transpose(),
          segment.covariances_m2[k], &belief);
    }
    run.filtered[k] = belief;
  }
  return run;
}

// Replaces the filter's estimates by the smoother's, from the last time to the
// first.
template <int kSize>
void SmoothBack(FilterRun<kSize>* run) {
  std::vector<Belief<kSize>>& beliefs = run->filtered;
  for (size_t k = beliefs.size() - 1; k-- > 0;) {
    // G = P F' P_predicted^-1 (Rauch, Tung and Striebel 1965, eq. 3.30).
    const Belief<kSize>& predicted = run->predicted[k + 1];
    const StateMatrix<kSize> G =
        predicted.covariance.ldlt()
            .solve(run->transitions[k + 1] * beliefs[k].covariance)
            .transpose();
    beliefs[k].mean += (G * (beliefs[k + 1].mean - predicted.mean)).eval();
    beliefs[k].covariance +=
        (G * (beliefs[k + 1].covariance - predicted.covariance) * G.transpose())
            .eval();
  }
}

enum class Pass { kForward, kForwardAndBack };

template <int kSize>
SegmentEstimate Estimate(const PointModel& model, const JointSegment& segment,
                         Pass pass) {
  FilterRun<kSize> run = RunFilter<kSize>(model, segment);
  if (pass == Pass::kForwardAndBack) SmoothBack(&run);
  const size_t count = run.filtered.size();
  SegmentEstimate estimate;
  const auto rows = static_cast<Eigen::Index>(count);
  estimate.positions_m.resize(rows, 3);
  estimate.velocities_m_s.resize(rows, 3);
  if (kSize == 9) estimate.accelerations_m_s2.resize(rows, 3);
  estimate.covariances_m2.reserve(count);
  for (size_t k = 0; k < count; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const auto& mean = run.filtered[k].mean;
    estimate.positions_m.row(row) = mean.template head<3>().transpose();
    estimate.velocities_m_s.row(row) = mean.template segment<3>(3).transpose();
    if constexpr (kSize == 9) {
      estimate.accelerations_m_s2.row(row) =
          mean.template tail<3>().transpose();
    }
    const Eigen::Matrix3d P =
        run.filtered[k].covariance.template topLeftCorner<3, 3>();
    estimate.covariances_m2.emplace_back(0.5 * (P + P.transpose()));
  }
  return estimate;
}

SegmentEstimate Estimate(const PointModel& model, const JointSegment& segment,
                         Pass pass) {
  return model.derivatives == 2 ? Estimate<6>(model, segment, pass)
                                : Estimate<9>(model, segment, pass);
}

}  // namespace

SegmentEstimate KalmanFilter(const PointModel& model,
                             const JointSegment& segment) {
  return Estimate(model, segment, Pass::kForward);
}

SegmentEstimate RtsSmoother(const PointModel& model,
                            const JointSegment& segment) {
  return Estimate(model, segment, Pass::kForwardAndBack);
}

SegmentEstimate StudentTSmoother(const PointModel& model,
                                 const JointSegment& segment) {
  constexpr double kFreedom = 4.0;
  constexpr int kMostRounds = 50;
  constexpr double kSettled = 1e-6;
  std::vector<double> weights(segment.times_s.size(), 1.0);
  JointSegment weighted = segment;
  SegmentEstimate estimate = RtsSmoother(model, segment);
  for (int round = 0; round < kMostRounds; ++round) {
    double change = 0.0;
    for (size_t k = 0; k < weights.size(); ++k) {
      if (!segment.sampled[k]) continue;
      const auto row = static_cast<Eigen::Index>(k);
      const Eigen::Vector3d e =
          (segment.positions_m.row(row) - estimate.positions_m.row(row))
              .transpose();
      const Eigen::LDLT<Eigen::Matrix3d> R(segment.covariances_m2[k]);
      const double squared =
          e.dot(R.solve(e)) + R.solve(*estimate.covariances_m2[k]).trace();
      const double weight = (kFreedom + 3.0) / (kFreedom + squared);
      change = std::max(change, std::abs(weight - weights[k]));
      weights[k] = weight;
      weighted.covariances_m2[k] = segment.covariances_m2[k] / weight;
    }
    if (change < kSettled) break;
    estimate = RtsSmoother(model, weighted);
  }
  return estimate;
}

PointModel ModelOf(const KalmanOptions& options, JointClass joint_class) {
  // Power of the white noise on acceleration or on jerk, as a multiple of
  // graph.process_noise.
  constexpr double kOfAcceleration = 0.5;
  constexpr double kOfJerk_per_s2 = 25.0;
  const double power = options.process_noise[static_cast<int>(joint_class)];
  PointModel model;
  const bool velocity = options.motion == MotionModel::kConstantVelocity;
  model.derivatives = velocity ? 2 : 3;
  model.power = options.process_noise_scale *
                ((velocity ? kOfAcceleration : kOfJerk_per_s2) * power);
  return model;
}

}  // namespace kinegraph
