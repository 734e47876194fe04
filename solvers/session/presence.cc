#include "solvers/session/presence.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/data/box.h"

namespace kinegraph {
namespace {

// Upper ends of all confidence bins except the last.
constexpr std::array<double, 8> kEnds = {0.01, 0.03, 0.1, 0.2,
                                         0.3,  0.4,  0.5, 0.6};
constexpr double kSure = 0.6;  // a high confidence
// Distance, as a fraction of a person's size in the image, beyond which a joint
// counts as astray: about a limb's length, as when a detector confuses two
// joints.
constexpr double kAstrayShare = 0.3;

}  // namespace

PresenceLearner::PresenceLearner(const CameraRig& cameras)
    : cameras_(cameras), epipolar_(cameras) {}

PresenceLearner::Ideal PresenceLearner::IdealOf(const Detection& detection,
                                                const Camera& camera) const {
  Ideal ideal;
  Eigen::AlignedBox2d box;
  for (Keypoint joint : detection.joints) {
    std::optional<Eigen::Vector2d> px;
    if (joint.found) px = camera.Undistort(joint.px);
    joint.found = px.has_value();
    if (joint.found) joint.px = *px;
    if (joint.found && joint.confidence >= kSure) box.extend(joint.px);
    ideal.joints.push_back(joint);
  }
  ideal.size_px = DiagonalPx(box);
  return ideal;
}

double PresenceLearner::SureDistance(int view_a, const Ideal& a, int view_b,
                                     const Ideal& b) const {
  constexpr size_t kFewest = 4;
  std::vector<double> distances;
  for (size_t j = 0; j < a.joints.size(); ++j) {
    const Keypoint& one = a.joints[j];
    const Keypoint& other = b.joints[j];
    if (!one.found || !other.found || one.confidence < kSure ||
        other.confidence < kSure) {
      continue;
    }
    distances.push_back(epipolar_.Distance(view_a, one.px, view_b, other.px));
  }
  return distances.size() < kFewest ? std::numeric_limits<double>::infinity()
                                    : Median(std::move(distances));
}

void PresenceLearner::See(const DetectionFrame& frame) {
  // Maximum epipolar distance between two detections of one person, as a
  // fraction of the size; different people are farther apart.
  constexpr double kOnePerson = 0.1;
  std::vector<std::vector<Ideal>> ideal;
  for (size_t v = 0; v < frame.views.size(); ++v) {
    ideal.emplace_back();
    for (const Detection& one : frame.views[v].detections) {
      ideal.back().push_back(IdealOf(one, cameras_[v]));
    }
  }
  const auto views = static_cast<int>(ideal.size());
  for (int a = 0; a < views; ++a) {
    for (int b = 0; b < views; ++b) {
      if (a == b) continue;
      for (const Ideal& one : ideal[a]) {
        const Ideal* nearest = nullptr;
        double nearest_px = kOnePerson * one.size_px;
        for (const Ideal& other : ideal[b]) {
          const double distance_px = SureDistance(a, one, b, other);
          if (distance_px >= nearest_px) continue;
          nearest = &other;
          nearest_px = distance_px;
        }
        if (nearest != nullptr) Compare(a, one, b, *nearest);
      }
    }
  }
}

void PresenceLearner::Compare(int view_a, const Ideal& a, int view_b,
                              const Ideal& b) {
  const double far_px = kAstrayShare * 0.5 * (a.size_px + b.size_px);
  for (size_t j = 0; j < a.joints.size(); ++j) {
    const Keypoint& one = a.joints[j];
    const Keypoint& other = b.joints[j];
    if (!one.found || !other.found || other.confidence < kSure) continue;
    const auto bin = static_cast<size_t>(
        std::upper_bound(kEnds.begin(), kEnds.end(), one.confidence) -
        kEnds.begin());
    ++bins_[bin].seen;
    bins_[bin].astray +=
        epipolar_.Distance(view_a, one.px, view_b, other.px) > far_px ? 1 : 0;
  }
}

double PresenceLearner::LeastConfidence() const {
  // Robust estimates tolerate a quarter of outliers: with three views, at least
  // two are correct in five of six cases.
  constexpr double kMostAstray = 0.25;
  constexpr int64_t kEnough = 50;
  // Higher confidence implies fewer errors: neighbouring bins that contradict
  // this are merged (pool adjacent violators). A bin with too few joints is
  // merged with the next one.
  struct Pool {
    int64_t seen = 0;
    int64_t astray = 0;
    double end = 0.0;  // upper end of its confidences
    double share() const {
      return static_cast<double>(astray) / static_cast<double>(seen);
    }
  };
  std::vector<Pool> pools;
  for (size_t i = 0; i < kEnds.size(); ++i) {
    if (bins_[i].seen == 0) continue;
    pools.push_back({bins_[i].seen, bins_[i].astray, kEnds[i]});
    while (pools.size() > 1 &&
           (pools.back().share() > pools[pools.size() - 2].share() ||
            pools[pools.size() - 2].seen < kEnough)) {
      Pool last = pools.back();
      pools.pop_back();
      pools.back().seen += last.seen;
      pools.back().astray += last.astray;
      pools.back().end = last.end;
    }
  }
  double least = 0.0;
  for (const Pool& pool : pools) {
    if (pool.seen < kEnough || pool.share() <= kMostAstray) break;
    least = pool.end;
  }
  return least;
}

void DropAbsentJoints(double least_confidence, DetectionFrame* frame) {
  if (!(least_confidence > 0.0)) return;
  for (ViewDetections& view : frame->views) {
    for (Detection& detection : view.detections) {
      for (Keypoint& joint : detection.joints) {
        if (joint.confidence < least_confidence) joint.found = false;
      }
    }
  }
}

}  // namespace kinegraph
