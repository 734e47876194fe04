#include "solvers/session/limbs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

// Limbs of a body and their share of its height: Drillis and Contini (1966),
// as Winter's "Biomechanics and Motor Control of Human Movement" tabulates
// them. The trunk goes from the middle of the hips to that of the shoulders.
struct Limb {
  const char* a;
  const char* b;
  double share;
};
constexpr std::array<Limb, kLimbCount> kLimbs = {{{"hip", "knee", 0.245},
                                                  {"knee", "ankle", 0.246},
                                                  {"shoulder", "elbow", 0.186},
                                                  {"elbow", "wrist", 0.146}}};
constexpr double kTrunkShare = 0.288;
constexpr double kLeastShare = 0.4;  // of the height: less says nothing of it

std::optional<double> Length(const Pose3d& pose, int a, int b) {
  if (a < 0 || b < 0) return std::nullopt;
  const Joint3d& from = pose[static_cast<size_t>(a)];
  const Joint3d& to = pose[static_cast<size_t>(b)];
  // What a bone factor or a prediction filled in says nothing new.
  if (from.status != JointStatus::kObserved ||
      to.status != JointStatus::kObserved) {
    return std::nullopt;
  }
  return (from.position_m - to.position_m).norm();
}

}  // namespace

LimbFigures FiguresOf(const LimbSamples& samples) {
  // Fewer lengths than this say nothing of a bone.
  constexpr int64_t kEnough = 10;
  LimbFigures figures;
  double length_m = 0.0;
  double share = 0.0;
  std::vector<double> spreads;
  std::vector<double> differences;
  for (size_t s = 0; s < kLimbCount; ++s) {
    std::array<double, 2> medians = {};
    for (size_t side = 0; side < 2; ++side) {
      const StreamSample& sample = samples.limbs[s][side];
      if (sample.count() < kEnough) continue;
      medians[side] = sample.Quantile(0.5);
      length_m += medians[side];
      share += kLimbs[s].share;
      spreads.push_back((sample.Quantile(0.9) - sample.Quantile(0.1)) /
                        medians[side]);
    }
    if (medians[0] > 0.0 && medians[1] > 0.0) {
      differences.push_back(std::abs(medians[0] - medians[1]) /
                            (0.5 * (medians[0] + medians[1])));
    }
  }
  if (samples.trunk.count() >= kEnough) {
    length_m += samples.trunk.Quantile(0.5);
    share += kTrunkShare;
  }
  if (share > kLeastShare) figures.height_m = length_m / share;
  if (!spreads.empty()) {
    std::sort(spreads.begin(), spreads.end());
    figures.bone_spread = spreads[spreads.size() / 2];
  }
  for (const double difference : differences) {
    figures.side_difference +=
        difference / static_cast<double>(differences.size());
  }
  return figures;
}

Limbs::Sides Limbs::SidesOf(const Skeleton& skeleton, const std::string& part) {
  return {skeleton.IndexOf("l_" + part), skeleton.IndexOf("r_" + part)};
}

Limbs::Limbs(const Skeleton& skeleton) {
  if (!IsHuman(skeleton)) return;
  hips_ = SidesOf(skeleton, "hip");
  shoulders_ = SidesOf(skeleton, "shoulder");
  for (size_t i = 0; i < kLimbCount; ++i) {
    limbs_[i] = {SidesOf(skeleton, kLimbs[i].a),
                 SidesOf(skeleton, kLimbs[i].b)};
  }
}

void Limbs::See(const Pose3d& pose, LimbSamples* samples) const {
  for (size_t i = 0; i < kLimbCount; ++i) {
    const auto& [a, b] = limbs_[i];
    const auto left = Length(pose, a.left, b.left);
    const auto right = Length(pose, a.right, b.right);
    if (left) samples->limbs[i][0].Add(*left);
    if (right) samples->limbs[i][1].Add(*right);
  }
  const auto hips = Middle(pose, hips_);
  const auto shoulders = Middle(pose, shoulders_);
  if (hips && shoulders) samples->trunk.Add((*hips - *shoulders).norm());
}

std::optional<double> Limbs::HeightOf(const Pose3d& pose) const {
  double length_m = 0.0;
  double share = 0.0;
  const auto add = [&](std::optional<double> seen_m, double its_share) {
    if (!seen_m.has_value()) return;
    length_m += *seen_m;
    share += its_share;
  };
  for (size_t i = 0; i < kLimbCount; ++i) {
    const auto& [a, b] = limbs_[i];
    add(Length(pose, a.left, b.left), kLimbs[i].share);
    add(Length(pose, a.right, b.right), kLimbs[i].share);
  }
  const auto hips = Middle(pose, hips_);
  const auto shoulders = Middle(pose, shoulders_);
  if (hips && shoulders) add((*hips - *shoulders).norm(), kTrunkShare);
  return share > kLeastShare ? std::optional<double>(length_m / share)
                             : std::nullopt;
}

std::optional<Eigen::Vector3d> Limbs::MiddleOfHips(const Pose3d& pose) const {
  return Middle(pose, hips_);
}

std::optional<Eigen::Vector3d> Limbs::Middle(const Pose3d& pose,
                                             const Sides& sides) {
  if (!Length(pose, sides.left, sides.right)) return std::nullopt;
  return 0.5 * (pose[static_cast<size_t>(sides.left)].position_m +
                pose[static_cast<size_t>(sides.right)].position_m);
}

}  // namespace kinegraph
