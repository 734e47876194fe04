#include "solvers/noise/bone_looks.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "core/skeleton/anthropometry.h"
#include "core/skeleton/body_joints.h"
#include "solvers/factors/jacobian.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Normal equations of the views with sufficient weight.
struct NormalEquations {
  Matrix3d information = Matrix3d::Zero();
  Matrix3d solver_information = Matrix3d::Zero();  // with the solver's weights
  Vector3d gradient = Vector3d::Zero();
  double square = 0.0;
  int views = 0;
};

// The equations at the state `at`; its velocity matters because cameras capture
// at different times.
NormalEquations Linearise(const JointChain& chain, size_t k,
                          double inlier_weight, const State& at) {
  NormalEquations sum;
  for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
    const PixelMeasurement& measurement = chain.measurements[m];
    if (measurement.gated || measurement.weight < inlier_weight) continue;
    Vector3d seen_m;
    PointAt(at.data(), measurement.offset_s, seen_m.data());
    Matrix23d jacobian;
    const auto image = measurement.camera->Project(seen_m, &jacobian);
    if (!image.has_value()) continue;
    const double sigma = measurement.sigma_px;
    const Eigen::Vector2d residual =
        (*image + measurement.bias_px.cast<double>() - measurement.px) / sigma;
    const Matrix23d whitened = jacobian / sigma;
    const Matrix3d square = whitened.transpose() * whitened;
    sum.information += square;
    sum.solver_information +=
        measurement.weight * measurement.information * square;
    sum.gradient += whitened.transpose() * residual;
    sum.square += residual.squaredNorm();
    ++sum.views;
  }
  return sum;
}

// Noise-equivalent averaging length [frames] of the smoother that is optimal
// for white noise on acceleration, H(w) = 1 / (1 + (w / w_c)^4) with w_c^4 = q
// / (R h): it averages over pi / (0.833 w_c) seconds (0.833: the integral of
// H^2 over w / w_c). Limited to a second, because motion is not stationary for
// longer.
double AveragedFrames(const JointChain& chain, size_t k, double variance_m2,
                      double interval_s) {
  if (chain.process_noise.empty()) return 1.0;
  const double noise =
      chain.process_noise[std::min(k, chain.process_noise.size() - 1)];
  const double crossover = std::pow(noise / (variance_m2 * interval_s), 0.25);
  const double seconds = std::min(1.0, 3.77 / crossover);
  return std::max(1.0, seconds / interval_s);
}

std::optional<BoneEnd> LocateEnd(const JointChain& chain, size_t k,
                                 double inlier_weight, double interval_s) {
  // Gauss-Newton from the estimate, which is close.
  constexpr int kSteps = 3;
  State at = chain.states[k];
  NormalEquations sum;
  for (int step = 0; step < kSteps; ++step) {
    sum = Linearise(chain, k, inlier_weight, at);
    if (sum.views < 2) return std::nullopt;
    const Eigen::LDLT<Matrix3d> factor(sum.information);
    // A standard deviation of ten metres counts as undetermined.
    constexpr double kOpen = 0.01;  // 1 / m^2
    if (!factor.isPositive() || !(factor.vectorD().minCoeff() > kOpen)) {
      return std::nullopt;
    }
    at.head<3>() -= factor.solve(sum.gradient);
  }
  BoneEnd end;
  end.estimate_m = chain.states[k].head<3>();
  end.position_m = at.head<3>();
  if (!end.position_m.allFinite()) return std::nullopt;
  end.covariance_m2 = sum.information.ldlt().solve(Matrix3d::Identity());
  end.square = sum.square;
  end.freedom = 2 * sum.views - 3;
  const Matrix3d of_solver =
      sum.solver_information.ldlt().solve(Matrix3d::Identity());
  end.averaged_frames =
      AveragedFrames(chain, k, of_solver.trace() / 3.0, interval_s);
  return end;
}

std::string WithoutSide(const std::string& joint) {
  const bool sided =
      joint.compare(0, 2, "l_") == 0 || joint.compare(0, 2, "r_") == 0;
  return sided ? joint.substr(2) : joint;
}

struct NamedLength {
  const char* a;
  const char* b;
  double length_m;
};

constexpr double kStature_m = 1.70;
constexpr std::array<NamedLength, 6> kPopulation = {{
    {"shoulder", "elbow", kUpperArmShare* kStature_m},
    {"elbow", "wrist", kForearmShare* kStature_m},
    {"hip", "knee", kThighShare* kStature_m},
    {"knee", "ankle", kShankShare* kStature_m},
    {"shoulder", "shoulder", 2.0 * kHalfShoulderShare* kStature_m},
    {"shoulder", "hip", kTrunkShare* kStature_m},
}};

}  // namespace

bool SameBone(const Bone& x, int a, int b) {
  return (x.a == a && x.b == b) || (x.a == b && x.b == a);
}

std::optional<double> PopulationLength(const Skeleton& skeleton,
                                       const Bone& bone) {
  if (!IsHuman(skeleton)) return std::nullopt;
  const std::string a = WithoutSide(skeleton.joints()[bone.a]);
  const std::string b = WithoutSide(skeleton.joints()[bone.b]);
  for (const NamedLength& known : kPopulation) {
    if ((a == known.a && b == known.b) || (a == known.b && b == known.a)) {
      return known.length_m;
    }
  }
  return std::nullopt;
}

std::vector<Bone> RigidPairs(const Skeleton& skeleton) {
  std::vector<Bone> pairs = skeleton.bones();
  if (!IsHuman(skeleton)) return pairs;
  std::vector<int> head;
  for (const char* joint : {"nose", "l_eye", "r_eye", "l_ear", "r_ear"}) {
    const int index = skeleton.IndexOf(joint);
    if (index >= 0) head.push_back(index);
  }
  for (size_t i = 0; i < head.size(); ++i) {
    for (size_t j = i + 1; j < head.size(); ++j) {
      const bool known = std::any_of(
          pairs.begin(), pairs.end(),
          [&](const Bone& bone) { return SameBone(bone, head[i], head[j]); });
      if (!known) pairs.push_back({head[i], head[j]});
    }
  }
  return pairs;
}

std::vector<std::optional<BoneEnd>> LocateBoneEnds(const PersonProblem& problem,
                                                   size_t frame_idx,
                                                   double inlier_weight,
                                                   double interval_s) {
  std::vector<std::optional<BoneEnd>> ends;
  ends.reserve(problem.joints.size());
  for (const JointChain& chain : problem.joints) {
    ends.push_back(LocateEnd(chain, frame_idx, inlier_weight, interval_s));
  }
  return ends;
}

std::optional<BoneObservation> LookAtBone(const BoneEnd& a, const BoneEnd& b) {
  const double distance = (a.position_m - b.position_m).norm();
  const Vector3d between = a.estimate_m - b.estimate_m;
  const double length = between.norm();
  if (!(distance > 0.0 && length > 0.0)) return std::nullopt;
  const Matrix3d noise = a.covariance_m2 + b.covariance_m2;
  const Vector3d along = between / length;
  BoneObservation look;
  look.variance_m2 = along.dot(noise * along);
  look.distance_m = distance;
  look.noise_m2 = noise.trace();
  look.noise_square_m4 = noise.squaredNorm();
  // E |d + e| = |d| + (variance across) / (2 |d|) to second order.
  look.added_m = (look.noise_m2 - look.variance_m2) / (2.0 * length);
  look.square = a.square + b.square;
  look.freedom = a.freedom + b.freedom;
  look.averaged_frames = std::max(a.averaged_frames, b.averaged_frames);
  return look;
}

}  // namespace kinegraph
