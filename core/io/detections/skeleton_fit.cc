#include "core/io/detections/skeleton_fit.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/median.h"
#include "core/data/box.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

constexpr size_t kMaxPeople = 4000;
constexpr int kMinJoints = 8;
constexpr size_t kMinBones = 4;

// Bones of arms, legs and trunk, which every human layout has; empty for other
// layouts.
std::vector<Bone> BonesOf(const Skeleton& skeleton) {
  if (!IsHuman(skeleton)) return {};
  std::vector<std::pair<std::string, std::string>> names = {
      {"l_shoulder", "r_shoulder"}, {"l_hip", "r_hip"}};
  for (const std::string side : {"l_", "r_"}) {
    for (const auto& [a, b] : {std::pair{"shoulder", "elbow"},
                               {"elbow", "wrist"},
                               {"hip", "knee"},
                               {"knee", "ankle"},
                               {"shoulder", "hip"}}) {
      names.emplace_back(side + a, side + b);
    }
  }
  std::vector<Bone> bones;
  for (const auto& [a, b] : names) {
    const Bone bone = {skeleton.IndexOf(a), skeleton.IndexOf(b)};
    if (bone.a >= 0 && bone.b >= 0) bones.push_back(bone);
  }
  return bones;
}

bool ShowsAnkle(const Detection& detection, const Skeleton& skeleton) {
  for (const char* name : {"l_ankle", "r_ankle"}) {
    const int joint = skeleton.IndexOf(name);
    if (joint >= 0 && detection.joints[static_cast<size_t>(joint)].found) {
      return true;
    }
  }
  return false;
}

}  // namespace

SkeletonFit::SkeletonFit(std::vector<const Skeleton*> candidates) {
  for (const Skeleton* skeleton : candidates) {
    const std::vector<Bone> bones = BonesOf(*skeleton);
    candidates_.push_back({skeleton, bones, {}, {}, {}});
    candidates_.back().lengths.resize(bones.size());
  }
}

void SkeletonFit::See(const Detection& detection) {
  if (CountFound(detection) < kMinJoints) return;
  const double diagonal_px = DiagonalPx(BoxAround(detection.joints));
  if (!(diagonal_px > 0.0)) return;
  for (Candidate& candidate : candidates_) {
    if (candidate.skeleton->joints().size() != detection.joints.size() ||
        candidate.shares.size() >= kMaxPeople) {
      continue;
    }
    double length_px = 0.0;
    std::vector<std::pair<size_t, double>> seen;  // bone and its length [px]
    for (size_t i = 0; i < candidate.bones.size(); ++i) {
      const Bone& bone = candidate.bones[i];
      const Keypoint& a = detection.joints[static_cast<size_t>(bone.a)];
      const Keypoint& b = detection.joints[static_cast<size_t>(bone.b)];
      if (!a.found || !b.found) continue;
      const double bone_px = (a.px - b.px).norm();
      length_px += bone_px;
      seen.emplace_back(i, bone_px);
    }
    if (seen.size() < kMinBones) continue;
    candidate.shares.push_back(length_px / static_cast<double>(seen.size()) /
                               diagonal_px);
    if (ShowsAnkle(detection, *candidate.skeleton)) {
      candidate.whole_shares.push_back(candidate.shares.back());
    }
    for (const auto& [bone, bone_px] : seen) {
      candidate.lengths[bone].push_back(bone_px / diagonal_px);
    }
  }
}

bool SkeletonFit::full() const { return people() >= kMaxPeople; }

size_t SkeletonFit::people() const {
  size_t most = 0;
  for (const Candidate& candidate : candidates_) {
    most = std::max(most, candidate.shares.size());
  }
  return most;
}

double SkeletonFit::MedianShare(size_t candidate_idx) const {
  return Median(candidates_[candidate_idx].shares);
}

bool SkeletonFit::Implausible(size_t candidate_idx) const {
  const std::vector<double>& shares = candidates_[candidate_idx].whole_shares;
  return shares.size() >= kEnoughPeople && Median(shares) > kImplausible;
}

double SkeletonFit::SideDifference(size_t candidate_idx) const {
  const Candidate& candidate = candidates_[candidate_idx];
  const Skeleton& skeleton = *candidate.skeleton;
  double sum = 0.0;
  int limbs = 0;
  for (size_t i = 0; i < candidate.bones.size(); ++i) {
    for (size_t k = i + 1; k < candidate.bones.size(); ++k) {
      const Bone& left = candidate.bones[i];
      const Bone& right = candidate.bones[k];
      if (skeleton.mirror(left.a) != right.a ||
          skeleton.mirror(left.b) != right.b) {
        continue;
      }
      const double a = Median(candidate.lengths[i]);
      const double b = Median(candidate.lengths[k]);
      if (!(a > 0.0) || !(b > 0.0)) continue;
      sum += std::abs(a - b) / (a + b);
      ++limbs;
    }
  }
  return limbs == 0 ? 0.0 : sum / limbs;
}

double SkeletonFit::Measure(size_t candidate_idx) const {
  return MedianShare(candidate_idx) * (1.0 + SideDifference(candidate_idx));
}

size_t SkeletonFit::Best() const {
  size_t best = 0;
  for (size_t c = 1; c < candidates_.size(); ++c) {
    const bool enough = candidates_[c].shares.size() >= kEnoughPeople &&
                        candidates_[0].shares.size() >= kEnoughPeople;
    if (enough && Measure(c) < kClearly * Measure(0) &&
        (best == 0 || Measure(c) < Measure(best))) {
      best = c;
    }
  }
  return best;
}

}  // namespace kinegraph
