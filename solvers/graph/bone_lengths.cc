#include "solvers/graph/bone_lengths.h"

#include <algorithm>
#include <array>

#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

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

// Shares of stature times 1.70 m.
constexpr std::array<NamedLength, 6> kPopulation = {{
    {"shoulder", "elbow", 0.186 * 1.70},
    {"elbow", "wrist", 0.146 * 1.70},
    {"hip", "knee", 0.245 * 1.70},
    {"knee", "ankle", 0.246 * 1.70},
    {"shoulder", "shoulder", 2.0 * 0.129 * 1.70},
    {"shoulder", "hip", 0.288 * 1.70},
}};

bool SameBone(const Bone& x, int a, int b) {
  return (x.a == a && x.b == b) || (x.a == b && x.b == a);
}

}  // namespace

std::optional<double> PopulationLength(const std::string& joint_a,
                                       const std::string& joint_b) {
  const std::string a = WithoutSide(joint_a);
  const std::string b = WithoutSide(joint_b);
  for (const NamedLength& known : kPopulation) {
    if ((a == known.a && b == known.b) || (a == known.b && b == known.a)) {
      return known.length_m;
    }
  }
  return std::nullopt;
}

std::vector<Bone> RigidPairs(const Skeleton& skeleton) {
  std::vector<Bone> pairs = skeleton.bones();
  std::vector<int> head;
  if (!IsHuman(skeleton)) return pairs;
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

BoneLengths::BoneLengths(const Skeleton& skeleton)
    : bones_(RigidPairs(skeleton)) {
  const bool is_human = IsHuman(skeleton);
  for (size_t i = 0; i < bones_.size(); ++i) {
    const int mirror_a = skeleton.mirror(bones_[i].a);
    const int mirror_b = skeleton.mirror(bones_[i].b);
    int group = -1;
    for (size_t other = 0; other < i; ++other) {
      if (SameBone(bones_[other], mirror_a, mirror_b)) group = group_[other];
    }
    if (group < 0) {
      group = static_cast<int>(seen_.size());
      seen_.push_back({std::vector<float>(kBinCount, 0.0f), 0.0});
      population_m_.push_back(
          is_human ? PopulationLength(skeleton.joints()[bones_[i].a],
                                      skeleton.joints()[bones_[i].b])
                   : std::nullopt);
    }
    group_.push_back(group);
  }
}

void BoneLengths::Add(int bone_idx, double distance_m, double duration_s) {
  if (!(distance_m >= 0.0)) return;
  const double bin = distance_m / kBin;
  if (bin >= kBinCount) return;
  Seen& seen = seen_[group_[bone_idx]];
  seen.seconds[static_cast<int>(bin)] += static_cast<float>(duration_s);
  seen.total_s += duration_s;
}

std::optional<double> BoneLengths::Length(int bone_idx) const {
  // Errors of a detector last about a fifth of a second: so many seconds make
  // one independent look, good to 4 cm. People differ by a tenth, and
  // detectors place joints elsewhere than anatomists do.
  constexpr double kLook = 0.2;
  constexpr double kLookSigma = 0.04;  // m
  constexpr double kPopulationShare = 0.15;
  constexpr double kEnough = 1.0;  // s, without a population's length
  const int group = group_[bone_idx];
  const Seen& seen = seen_[group];
  const std::optional<double>& population_m = population_m_[group];
  if (!population_m.has_value() && seen.total_s < kEnough) return std::nullopt;
  if (seen.total_s <= 0.0) return population_m;

  double below = 0.0;
  int bin = 0;
  while (bin < kBinCount - 1 &&
         below + seen.seconds[bin] < 0.5 * seen.total_s) {
    below += seen.seconds[bin++];
  }
  const double inside = std::max<double>(seen.seconds[bin], 1e-12);
  const double share =
      std::clamp((0.5 * seen.total_s - below) / inside, 0.0, 1.0);
  const double median_m = (bin + share) * kBin;
  if (!population_m.has_value()) return median_m;
  const double information = seen.total_s / kLook / (kLookSigma * kLookSigma);
  const double sigma_m = kPopulationShare * *population_m;
  const double prior = 1.0 / (sigma_m * sigma_m);
  return (information * median_m + prior * *population_m) /
         (information + prior);
}

}  // namespace kinegraph
