#include "solvers/person/rivals.h"

#include <algorithm>

namespace kinegraph {
namespace {

bool Inlier(const PixelMeasurement& measurement, double inlier_weight) {
  return !measurement.gated && measurement.weight >= inlier_weight;
}

bool Lost(const JointChain& chain, size_t k, double inlier_weight) {
  const int views = chain.first[k + 1] - chain.first[k];
  if (views < 3) return false;
  int inliers = 0;
  for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
    if (Inlier(chain.measurements[m], inlier_weight)) ++inliers;
  }
  return 2 * inliers <= views;
}

}  // namespace

std::vector<LostStretch> LostStretches(const JointChain& chain,
                                       double inlier_weight) {
  constexpr size_t kBridged = 3;
  constexpr size_t kLeast = 2;
  std::vector<LostStretch> stretches;
  std::vector<size_t> lost;  // frames of each stretch
  for (size_t k = 0; k < chain.states.size(); ++k) {
    if (!Lost(chain, k, inlier_weight)) continue;
    if (!stretches.empty() && k - stretches.back().end <= kBridged) {
      stretches.back().end = k + 1;
      ++lost.back();
    } else {
      stretches.push_back({k, k + 1});
      lost.push_back(1);
    }
  }
  std::vector<LostStretch> long_enough;
  for (size_t i = 0; i < stretches.size(); ++i) {
    if (lost[i] >= kLeast) long_enough.push_back(stretches[i]);
  }
  return long_enough;
}

std::vector<char> MaskFor(RivalMask mask,
                          const std::vector<LostStretch>& stretches,
                          double inlier_weight, const JointChain& chain) {
  std::vector<char> masked(chain.measurements.size(), 0);
  for (const LostStretch& stretch : stretches) {
    const size_t begin = stretch.begin > 0 ? stretch.begin - 1 : 0;
    const size_t end = std::min(stretch.end + 1, chain.states.size());
    for (int32_t m = chain.first[begin]; m < chain.first[end]; ++m) {
      masked[m] = mask == RivalMask::kAll ||
                  Inlier(chain.measurements[m], inlier_weight);
    }
  }
  return masked;
}

}  // namespace kinegraph
