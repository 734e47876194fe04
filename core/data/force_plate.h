// The load on a force plate, over time.
#ifndef KINEGRAPH_CORE_DATA_FORCE_PLATE_H_
#define KINEGRAPH_CORE_DATA_FORCE_PLATE_H_

#include <Eigen/Core>
#include <vector>

namespace kinegraph {

struct ForcePlate {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // world
  double first_s = 0.0;  // first sample, on the clock of the file's markers
  double rate_hz = 0.0;
  // Normal force [N]; its sign is chosen so that the sum is not negative.
  std::vector<double> load_n;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_FORCE_PLATE_H_
