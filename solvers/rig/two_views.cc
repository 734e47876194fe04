#include "solvers/rig/two_views.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "solvers/cameras/camera_change.h"

namespace kinegraph {
namespace {

// The transformation that moves the points' centroid to the origin and scales
// their mean distance from it to sqrt(2).
Eigen::Matrix3d Balance(const std::vector<PointPair>& pairs,
                        Eigen::Vector2d PointPair::*side) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const PointPair& pair : pairs) middle += pair.*side;
  middle /= static_cast<double>(pairs.size());
  double distance = 0.0;
  for (const PointPair& pair : pairs) distance += (pair.*side - middle).norm();
  distance /= static_cast<double>(pairs.size());
  const double scale = std::sqrt(2.0) / std::max(distance, 1e-12);
  Eigen::Matrix3d balance = Eigen::Matrix3d::Identity();
  balance.topLeftCorner<2, 2>() *= scale;
  balance.block<2, 1>(0, 2) = -scale * middle;
  return balance;
}

// The matrix of least algebraic error; nullopt if the null space has more than
// one dimension.
std::optional<Eigen::Matrix3d> LinearFit(const std::vector<PointPair>& pairs) {
  const Eigen::Matrix3d Ta = Balance(pairs, &PointPair::a);
  const Eigen::Matrix3d Tb = Balance(pairs, &PointPair::b);
  Eigen::Matrix<double, 9, 9> moments = Eigen::Matrix<double, 9, 9>::Zero();
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d a = Ta * pair.a.homogeneous();
    const Eigen::Vector3d b = Tb * pair.b.homogeneous();
    Eigen::Matrix<double, 9, 1> row;
    row << b.x() * a, b.y() * a, b.z() * a;
    moments.noalias() += row * row.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(
      moments);
  if (solver.info() != Eigen::Success) return std::nullopt;
  // Coplanar points leave two more directions undetermined.
  constexpr double kOpen = 1e-9;  // relative eigenvalue of the null space
  if (solver.eigenvalues()[1] < kOpen * solver.eigenvalues()[8]) {
    return std::nullopt;
  }
  const Eigen::Matrix<double, 9, 1> f = solver.eigenvectors().col(0);
  Eigen::Matrix3d F;
  F << f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8];
  return Eigen::Matrix3d(Tb.transpose() * F * Ta);
}

std::array<RelativePose, 4> PosesOf(const Eigen::Matrix3d& essential,
                                    double magnification) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  Eigen::Matrix3d V = svd.matrixV();
  if (U.determinant() < 0.0) U.col(2) *= -1.0;
  if (V.determinant() < 0.0) V.col(2) *= -1.0;
  Eigen::Matrix3d W;
  W << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  const Eigen::Matrix3d one = U * W * V.transpose();
  const Eigen::Matrix3d other = U * W.transpose() * V.transpose();
  const Eigen::Vector3d t = U.col(2);
  return {{{one, t, magnification},
           {one, -t, magnification},
           {other, t, magnification},
           {other, -t, magnification}}};
}

// Basis of the tangent plane of the unit sphere at `t`.
Eigen::Matrix<double, 3, 2> Tangents(const Eigen::Vector3d& t) {
  Eigen::Matrix<double, 3, 2> tangents;
  tangents.col(0) = t.unitOrthogonal();
  tangents.col(1) = t.cross(tangents.col(0));
  return tangents;
}

using Step = Eigen::Matrix<double, 6, 1>;

RelativePose Moved(const RelativePose& pose, const Step& step) {
  RelativePose moved;
  moved.R = ExpRotation(step.head<3>()) * pose.R;
  moved.t = (pose.t + Tangents(pose.t) * step.segment<2>(3)).normalized();
  moved.magnification = pose.magnification * std::exp(step[5]);
  return moved;
}

// Signed Sampson distance, in units of the person's size.
double SignedSampson(const Eigen::Matrix3d& essential, double magnification,
                     const PointPair& pair) {
  const Eigen::Vector3d a = (pair.a / magnification).homogeneous();
  const Eigen::Vector3d b = (pair.b / magnification).homogeneous();
  const Eigen::Vector3d line_b = essential * a;
  const Eigen::Vector3d line_a = essential.transpose() * b;
  const double length = std::sqrt(line_b.head<2>().squaredNorm() +
                                  line_a.head<2>().squaredNorm());
  if (!(length > 0.0)) return 0.0;
  return b.dot(line_b) / length * magnification / pair.size;
}

// Normal equations (information and gradient) of the robust Sampson distances
// in the first `size` parameters, with numeric derivatives.
std::pair<Eigen::Matrix<double, 6, 6>, Step> Linearise(
    const std::vector<PointPair>& pairs, const RelativePose& pose, double scale,
    int size) {
  constexpr double kSmall = 1e-6;  // step of the numeric derivatives
  std::array<RelativePose, 6> nudged;
  std::array<Eigen::Matrix3d, 6> essentials;
  for (int i = 0; i < size; ++i) {
    nudged[i] = Moved(pose, kSmall * Step::Unit(i));
    essentials[i] = nudged[i].Essential();
  }
  const Eigen::Matrix3d essential = pose.Essential();
  auto normal = std::make_pair(Eigen::Matrix<double, 6, 6>::Zero().eval(),
                               Step::Zero().eval());
  auto& [H, g] = normal;
  for (const PointPair& pair : pairs) {
    const double r = SignedSampson(essential, pose.magnification, pair) / scale;
    const double weight = 1.0 / (1.0 + r * r);
    Step J = Step::Zero();
    for (int i = 0; i < size; ++i) {
      const auto k = static_cast<size_t>(i);
      J[i] =
          (SignedSampson(essentials[k], nudged[k].magnification, pair) / scale -
           r) /
          kSmall;
    }
    H.noalias() += weight * J * J.transpose();
    g += weight * r * J;
  }
  return normal;
}

}  // namespace

Eigen::Matrix3d RelativePose::Essential() const { return CrossMatrix(t) * R; }

double RobustCost(const std::vector<PointPair>& pairs, const RelativePose& pose,
                  double scale) {
  const Eigen::Matrix3d essential = pose.Essential();
  double cost = 0.0;
  for (const PointPair& pair : pairs) {
    const double r = SignedSampson(essential, pose.magnification, pair) / scale;
    cost += 0.5 * std::log1p(r * r);
  }
  return cost;
}

double SampsonSquared(const Eigen::Matrix3d& essential, double magnification,
                      const PointPair& pair) {
  const double r = SignedSampson(essential, magnification, pair);
  return r * r;
}

std::optional<Eigen::Vector2d> DepthsOf(const RelativePose& pose,
                                        const PointPair& pair) {
  const Eigen::Vector3d a =
      pose.R * (pair.a / pose.magnification).homogeneous();
  const Eigen::Vector3d b = (pair.b / pose.magnification).homogeneous();
  // Least squares solution of d_a a + t = d_b b.
  Eigen::Matrix<double, 3, 2> A;
  A << a, -b;
  const Eigen::Matrix2d H = A.transpose() * A;
  const double determinant = H.determinant();
  constexpr double kParallel = 1e-4;  // squared sine of the rays' angle
  if (determinant < kParallel * H(0, 0) * H(1, 1)) return std::nullopt;
  return Eigen::Vector2d(H.inverse() * A.transpose() * -pose.t);
}

std::optional<RelativePose> EightPoint(const std::vector<PointPair>& pairs,
                                       double magnification) {
  if (pairs.size() < 8) return std::nullopt;
  const auto F = LinearFit(pairs);
  if (!F.has_value()) return std::nullopt;
  const Eigen::Vector3d scale(magnification, magnification, 1.0);
  const Eigen::Matrix3d E = scale.asDiagonal() * *F * scale.asDiagonal();
  return WithMostInFront(pairs, PosesOf(E, magnification)[0]);
}

RelativePose WithMostInFront(const std::vector<PointPair>& pairs,
                             const RelativePose& pose) {
  RelativePose best = pose;
  int most = -1;
  for (const RelativePose& one :
       PosesOf(pose.Essential(), pose.magnification)) {
    int in_front = 0;
    for (const PointPair& pair : pairs) {
      const auto depths = DepthsOf(one, pair);
      in_front += depths.has_value() && depths->minCoeff() > 0.0 ? 1 : 0;
    }
    if (in_front <= most) continue;
    most = in_front;
    best = one;
  }
  return best;
}

RelativePose RefinePose(const std::vector<PointPair>& pairs,
                        const RelativePose& start, double scale,
                        double focal_sigma) {
  constexpr int kIterations = 15;
  RelativePose pose = start;
  const int size = focal_sigma > 0.0 ? 6 : 5;
  const auto prior_of = [&](const RelativePose& at) {
    if (size < 6) return 0.0;
    const double off = std::log(at.magnification) / focal_sigma;
    return 0.5 * off * off;
  };
  double cost = RobustCost(pairs, pose, scale) + prior_of(pose);
  double damping = 1e-3;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    auto [H, g] = Linearise(pairs, pose, scale, size);
    if (size == 6) {
      H(5, 5) += 1.0 / (focal_sigma * focal_sigma);
      g[5] += std::log(pose.magnification) / (focal_sigma * focal_sigma);
    } else {
      H(5, 5) = 1.0;
    }
    bool better = false;
    for (int attempt = 0; attempt < 6 && !better; ++attempt) {
      Eigen::Matrix<double, 6, 6> damped = H;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-12;
      const Step step = damped.ldlt().solve(-g);
      const RelativePose moved = Moved(pose, step);
      const double after = RobustCost(pairs, moved, scale) + prior_of(moved);
      better = after < cost;
      damping *= better ? 0.3 : 6.0;
      if (!better) continue;
      const bool small = cost - after < 1e-6 * cost;
      pose = moved;
      cost = after;
      if (small) return pose;
    }
    if (!better) break;
  }
  return pose;
}

}  // namespace kinegraph
