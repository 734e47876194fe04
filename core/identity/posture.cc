#include "core/identity/posture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/base/median.h"

namespace kinegraph {
namespace {

constexpr size_t kMinCommon = 8;      // of twelve joints
constexpr double kLeastWidth = 0.05;  // m; shorter: no direction
// Postures of recorded people (walk, dance, hop, stand): the root mean square
// distance between two postures of one person has the median 0.08 m after 0.1
// s, 0.11 after 0.2, 0.18 after 0.5 and 0.2 from 1 s on; that of two people has
// the median 0.28 m. Half of each distribution lies within a quarter of its
// median.
constexpr double kSwing = 0.21;       // m, asymptotic
constexpr double kSwingGrows = 0.45;  // s
constexpr double kLeastSwing = 0.06;  // m, error of two poses
constexpr double kStrangers = 0.28;   // m
constexpr double kLogSpread = 0.4;    // of each distribution
// A hidden person may have changed activity: the share that continues, and its
// decay.
constexpr double kGoesOn = 0.9;
constexpr double kGoesOnLong = 3.0;  // s
constexpr double kMost = 2.5;        // nats, upper bound of the log ratio
// Interval at which people present at the same time are compared.
constexpr double kCompareEvery = 0.5;  // s
constexpr size_t kMinStrangers = 20;   // pairs of postures

double Swing(double gap_s) {
  return std::max(kLeastSwing,
                  kSwing * std::sqrt(1.0 - std::exp(-gap_s / kSwingGrows)));
}

// Rows x to the left, y backward, z up; nullopt where the heading is unknown.
std::optional<Eigen::Matrix3d> Axes(const LimbPosture& posture,
                                    const Eigen::Vector3d& up) {
  const Eigen::Vector3d across =
      posture.across_m - posture.across_m.dot(up) * up;
  if (!(across.norm() >= kLeastWidth)) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.row(0) = across.normalized();
  axes.row(1) = up.cross(across).normalized();
  axes.row(2) = up;
  return axes;
}

}  // namespace

std::optional<double> PostureDistance(const LimbPosture& a,
                                      const LimbPosture& b,
                                      const Eigen::Vector3d& up) {
  const auto axes_a = Axes(a, up);
  const auto axes_b = Axes(b, up);
  if (!axes_a.has_value() || !axes_b.has_value()) return std::nullopt;
  double sum = 0.0;
  size_t common = 0;
  for (size_t i = 0; i < std::min(a.limbs_m.size(), b.limbs_m.size()); ++i) {
    const double apart =
        (*axes_a * a.limbs_m[i] - *axes_b * b.limbs_m[i]).squaredNorm();
    if (!std::isfinite(apart)) continue;
    sum += apart;
    ++common;
  }
  if (common < kMinCommon) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(common));
}

PostureModel::PostureModel(const std::vector<Tracklet>& tracklets,
                           const Eigen::Vector3d& up)
    : up_(up), strangers_m_(kStrangers) {
  // The postures of all people twice a second, by time.
  std::map<int64_t, std::vector<LimbPosture>> moments;
  for (const Tracklet& tracklet : tracklets) {
    int64_t last = std::numeric_limits<int64_t>::min();
    for (size_t k = 0; k < tracklet.frames.size(); ++k) {
      const int64_t moment =
          tracklet.frames[k].time / FromSeconds(kCompareEvery);
      if (moment == last) continue;
      last = moment;
      moments[moment].push_back(PostureOf(tracklet, k));
    }
  }
  std::vector<double> distances;
  for (const auto& [moment, postures] : moments) {
    for (size_t a = 0; a < postures.size(); ++a) {
      for (size_t b = a + 1; b < postures.size(); ++b) {
        const auto distance = PostureDistance(postures[a], postures[b], up);
        if (distance.has_value()) distances.push_back(*distance);
      }
    }
  }
  if (distances.size() >= kMinStrangers) {
    strangers_m_ = Median(std::move(distances));
  }
}

double PostureModel::LogRatio(const LimbPosture& from, const LimbPosture& to,
                              double gap_s) const {
  const std::optional<double> distance = PostureDistance(from, to, up_);
  if (!distance.has_value()) return 0.0;
  const double swing = Swing(gap_s);
  // Where everyone does the same, posture is no evidence.
  const double strangers = std::max(strangers_m_, swing);
  const double x = std::log(std::max(*distance, kLeastSwing));
  const auto squared = [&](double median) {
    const double away = (x - std::log(median)) / kLogSpread;
    return away * away;
  };
  const double goes_on = kGoesOn * std::exp(-gap_s / kGoesOnLong);
  const double ratio =
      std::exp(std::min(kMost, 0.5 * (squared(strangers) - squared(swing))));
  return std::log(1.0 - goes_on + goes_on * ratio);
}

}  // namespace kinegraph
