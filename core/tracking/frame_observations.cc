#include "core/tracking/frame_observations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/data/box.h"

namespace kinegraph {
namespace {

bool IsBetter(const Observation& a, const Observation& b) {
  if (a.found_count != b.found_count) return a.found_count > b.found_count;
  return a.mean_confidence > b.mean_confidence;
}

// The boxes are around the joints.
bool IsOnePerson(const Observation& a, const Eigen::AlignedBox2d& box_a,
                 const Observation& b, const Eigen::AlignedBox2d& box_b) {
  constexpr double kApart = 0.05;  // mean distance, as a share of the diagonal
  const double most_px =
      kApart * std::max(DiagonalPx(box_a), DiagonalPx(box_b));
  if (GapPx(box_a, box_b) > most_px) return false;
  double sum_px = 0.0;
  int common = 0;
  int found_a = 0;
  int found_b = 0;
  for (size_t j = 0; j < a.joints.size(); ++j) {
    found_a += a.joints[j].found ? 1 : 0;
    found_b += b.joints[j].found ? 1 : 0;
    if (!a.joints[j].found || !b.joints[j].found) continue;
    ++common;
    sum_px += (a.joints[j].px - b.joints[j].px).norm();
  }
  return 2 * common >= std::min(found_a, found_b) && common > 0 &&
         sum_px < most_px * common;
}

}  // namespace

size_t SuppressDuplicates(size_t count,
                          std::vector<Observation>* observations) {
  std::vector<Observation>& all = *observations;
  std::vector<Eigen::AlignedBox2d> boxes;
  for (size_t i = 0; i < count; ++i) boxes.push_back(BoxAround(all[i].joints));
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    size_t same = 0;
    while (same < kept &&
           !IsOnePerson(all[same], boxes[same], all[i], boxes[i])) {
      ++same;
    }
    if (same < kept && !IsBetter(all[i], all[same])) continue;
    if (same != i) {
      std::swap(all[same], all[i]);
      std::swap(boxes[same], boxes[i]);
    }
    if (same == kept) ++kept;
  }
  return kept;
}

FrameObservations::FrameObservations(const CameraRig& cameras,
                                     const Skeleton& detections,
                                     const Skeleton& tracks,
                                     double min_found_joints,
                                     bool suppress_duplicates)
    : cameras_(&cameras),
      joint_map_(MapByName(detections, tracks)),
      counted_joints_(tracks.association_joints()),
      min_found_joints_(
          std::max(1, ScaledJoints(min_found_joints, counted_joints_.size()))),
      suppress_duplicates_(suppress_duplicates),
      observations_(cameras.size()),
      counts_(cameras.size(), 0) {}

void FrameObservations::Prepare(const DetectionFrame& frame) {
  if (frame.views.size() != cameras_->size()) {
    throw OptionError("frame " + std::to_string(frame.frame),
                      "found " + std::to_string(frame.views.size()) +
                          " views, expected one for each of the " +
                          std::to_string(cameras_->size()) + " cameras");
  }
  for (size_t v = 0; v < frame.views.size(); ++v) {
    std::vector<Observation>& observations = observations_[v];
    size_t count = 0;
    for (const Detection& detection : frame.views[v].detections) {
      if (count == observations.size()) observations.emplace_back();
      MakeObservation(detection, joint_map_, counted_joints_, (*cameras_)[v],
                      static_cast<int>(v), frame.views[v].capture_time,
                      &observations[count]);
      if (observations[count].found_count >= min_found_joints_) ++count;
    }
    counts_[v] =
        suppress_duplicates_ ? SuppressDuplicates(count, &observations) : count;
  }
}

}  // namespace kinegraph
