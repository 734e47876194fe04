#include "solvers/graph/problem.h"

namespace kinegraph {

void GateMeasurements(JointChain* chain) {
  for (size_t k = 0; k < chain->states.size(); ++k) {
    const State& state = chain->states[k];
    for (int32_t m = chain->first[k]; m < chain->first[k + 1]; ++m) {
      PixelMeasurement& measurement = chain->measurements[m];
      const Eigen::Vector3d point =
          state.head<3>() + measurement.offset_s * state.tail<3>();
      measurement.gated = !measurement.camera->Project(point).has_value();
      measurement.weight = 0.0;
    }
  }
}

}  // namespace kinegraph
