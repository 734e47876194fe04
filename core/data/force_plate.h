// The load on a force plate, over time.
#ifndef KINEGRAPH_CORE_DATA_FORCE_PLATE_H_
#define KINEGRAPH_CORE_DATA_FORCE_PLATE_H_

#include <Eigen/Core>
#include <vector>

namespace kinegraph {

struct ForcePlate {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // world
  double first_s = 0.0;  // time of the first sample, on the points' clock
  double rate_hz = 0.0;
  std::vector<double> load_n;  // normal to the plate, positive
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_FORCE_PLATE_H_
