// Where in the image a detection is.
#ifndef KINEGRAPH_CORE_DATA_BOX_H_
#define KINEGRAPH_CORE_DATA_BOX_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/data/detection.h"

namespace kinegraph {

// The upright box around the joints that were found [px]; empty without any.
inline Eigen::AlignedBox2d BoxAround(const std::vector<Keypoint>& joints) {
  Eigen::AlignedBox2d box;
  for (const Keypoint& joint : joints) {
    if (joint.found) box.extend(joint.px);
  }
  return box;
}

// Length of a box' diagonal, a person's size in the image [px]; 0 for an empty
// one.
inline double DiagonalPx(const Eigen::AlignedBox2d& box) {
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_BOX_H_
