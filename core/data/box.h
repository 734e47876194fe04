// The position of a detection in the image.
#ifndef KINEGRAPH_CORE_DATA_BOX_H_
#define KINEGRAPH_CORE_DATA_BOX_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "core/data/detection.h"

namespace kinegraph {

// The upright box around the found joints [px]; empty if there are none.
inline Eigen::AlignedBox2d BoxAround(const std::vector<Keypoint>& joints) {
  Eigen::AlignedBox2d box;
  for (const Keypoint& joint : joints) {
    if (joint.found) box.extend(joint.px);
  }
  return box;
}

// Length of a box's diagonal, a person's size in the image [px]; 0 for an empty
// box.
inline double DiagonalPx(const Eigen::AlignedBox2d& box) {
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

// Lower bound of the distance between a joint in `a` and a joint in `b` [px];
// at least the largest double if a box is empty.
inline double GapPx(const Eigen::AlignedBox2d& a,
                    const Eigen::AlignedBox2d& b) {
  return std::max({a.min().x() - b.max().x(), b.min().x() - a.max().x(),
                   a.min().y() - b.max().y(), b.min().y() - a.max().y(), 0.0});
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_BOX_H_
