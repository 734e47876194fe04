#include "core/tracking/duplicate_suppression.h"

#include <algorithm>
#include <utility>

#include "core/data/box.h"

namespace kinegraph {
namespace {

bool IsBetter(const Observation& a, const Observation& b) {
  if (a.found_count != b.found_count) return a.found_count > b.found_count;
  return a.mean_confidence > b.mean_confidence;
}

}  // namespace

bool IsOnePerson(const Observation& a, const Observation& b) {
  return IsOnePerson(a, BoxAround(a.joints), b, BoxAround(b.joints));
}

bool IsOnePerson(const Observation& a, const Eigen::AlignedBox2d& box_a,
                 const Observation& b, const Eigen::AlignedBox2d& box_b) {
  constexpr double kApart = 0.05;
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

}  // namespace kinegraph
