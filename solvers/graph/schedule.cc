#include "solvers/graph/schedule.h"

namespace kinegraph {

SolveSchedule MakeSchedule(const GraphOptions& options) {
  // 1.5 sigmas: nearly efficient for clean observations, yet an outlier pulls
  // like two good ones at most (Huber and Ronchetti, Robust Statistics).
  constexpr double kHuberScale = 1.5;
  // Earlier stages only hand over a start.
  constexpr int kEarlyIterations = 3;
  const int last_iterations = static_cast<int>(options.max_iterations);
  SolveSchedule schedule;
  schedule.step_tolerance_m = options.step_tolerance_m;
  if (IsConvex(options.loss)) {
    schedule.stages = {{options.loss, options.loss_scale, last_iterations}};
    return schedule;
  }
  schedule.stages.push_back({LossKind::kHuber, kHuberScale, kEarlyIterations});
  for (const double multiple : options.stages) {
    schedule.stages.push_back(
        {options.loss, multiple * options.loss_scale, kEarlyIterations});
  }
  schedule.stages.back().max_iterations = last_iterations;
  return schedule;
}

}  // namespace kinegraph
