#include "solvers/filters/kalman.h"

#include <Eigen/Cholesky>

namespace kinegraph {
namespace {

// Three coordinates of each derivative, position first.
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

template <int kSize>
SegmentEstimate Estimate(const PointModel& model, const JointSegment& segment,
                         bool smooth) {
  const size_t count = segment.times_s.size();
  std::vector<Belief<kSize>> filtered(count);
  std::vector<Belief<kSize>> predicted(count);
  std::vector<StateMatrix<kSize>> transitions(count);
  const auto position = [&](size_t k) -> Eigen::Vector3d {
    return segment.positions_m.row(static_cast<Eigen::Index>(k)).transpose();
  };
  Belief<kSize> belief;
  belief.mean.setZero();
  belief.mean.template head<3>() = position(0);
  belief.covariance.setZero();
  belief.covariance.template topLeftCorner<3, 3>() = segment.covariances_m2[0];
  for (int d = 1; d < kSize / 3; ++d) {
    const double sigma = model.start_sigmas[d - 1];
    belief.covariance.template block<3, 3>(3 * d, 3 * d)
        .diagonal()
        .setConstant(sigma * sigma);
  }
  filtered[0] = belief;
  for (size_t k = 1; k < count; ++k) {
    const double dt_s = segment.times_s[k] - segment.times_s[k - 1];
    transitions[k] = InSpace<kSize>(TransitionMatrix(kSize / 3, dt_s));
    belief.mean = (transitions[k] * belief.mean).eval();
    belief.covariance =
        (transitions[k] * belief.covariance * transitions[k].transpose() +
         InSpace<kSize>(ProcessNoise(kSize / 3, model.power, dt_s)))
            .eval();
    predicted[k] = belief;
    if (segment.sampled[k]) {
      Update<kSize>(position(k), segment.covariances_m2[k], &belief);
    }
    filtered[k] = belief;
  }
  for (size_t k = count - 1; smooth && k-- > 0;) {
    // G = P F' P_predicted^-1 (Rauch, Tung and Striebel 1965, eq. 3.30).
    const StateMatrix<kSize> G =
        predicted[k + 1]
            .covariance.ldlt()
            .solve(transitions[k + 1] * filtered[k].covariance)
            .transpose();
    filtered[k].mean +=
        (G * (filtered[k + 1].mean - predicted[k + 1].mean)).eval();
    filtered[k].covariance +=
        (G * (filtered[k + 1].covariance - predicted[k + 1].covariance) *
         G.transpose())
            .eval();
  }
  SegmentEstimate estimate;
  estimate.positions_m.resize(static_cast<Eigen::Index>(count), 3);
  estimate.covariances_m2.reserve(count);
  for (size_t k = 0; k < count; ++k) {
    estimate.positions_m.row(static_cast<Eigen::Index>(k)) =
        filtered[k].mean.template head<3>().transpose();
    const Eigen::Matrix3d P =
        filtered[k].covariance.template topLeftCorner<3, 3>();
    estimate.covariances_m2.emplace_back(0.5 * (P + P.transpose()));
  }
  return estimate;
}

}  // namespace

void KalmanOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("motion", &motion,
                 {"constant_velocity", "constant_acceleration"},
                 "what moves on undisturbed");
  DescribeJointClasses(
      visitor, "acceleration_noise", &acceleration_noise, "m^2/s^3",
      "constant velocity: power of the white noise on acceleration");
  DescribeJointClasses(
      visitor, "jerk_noise", &jerk_noise, "m^2/s^5",
      "constant acceleration: power of the white noise on jerk");
  visitor.Number("process_noise_scale", &process_noise_scale, Positive(), "",
                 "factor on the noise of every class");
  visitor.Choice("measurement", &measurement, {"triangulation", "constant"},
                 "covariance of a sample: its triangulation's, or sigma");
  DescribeJointClasses(visitor, "sigma", &sigma_m, "m",
                       "constant measurement noise, each coordinate");
  visitor.Number("start_velocity_sigma", &start_velocity_sigma_mps, Positive(),
                 "m/s", "spread of a segment's first velocity");
  visitor.Number("start_acceleration_sigma", &start_acceleration_sigma_mps2,
                 Positive(), "m/s^2", "the same of its first acceleration");
}

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

SegmentEstimate KalmanFilter(const PointModel& model,
                             const JointSegment& segment) {
  return model.derivatives == 2 ? Estimate<6>(model, segment, false)
                                : Estimate<9>(model, segment, false);
}

SegmentEstimate RtsSmoother(const PointModel& model,
                            const JointSegment& segment) {
  return model.derivatives == 2 ? Estimate<6>(model, segment, true)
                                : Estimate<9>(model, segment, true);
}

PointModel ModelOf(const KalmanOptions& options, JointClass joint_class) {
  const int index = static_cast<int>(joint_class);
  PointModel model;
  const bool velocity = options.motion == MotionModel::kConstantVelocity;
  model.derivatives = velocity ? 2 : 3;
  model.power = options.process_noise_scale *
                (velocity ? options.acceleration_noise[index]
                          : options.jerk_noise[index]);
  model.start_sigmas = {options.start_velocity_sigma_mps,
                        options.start_acceleration_sigma_mps2};
  return model;
}

}  // namespace kinegraph
