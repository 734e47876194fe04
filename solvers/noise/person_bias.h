// One person's part in the detector's bias: what its solution tells of it, and
// what it takes from its pixels.
#ifndef KINEGRAPH_SOLVERS_NOISE_PERSON_BIAS_H_
#define KINEGRAPH_SOLVERS_NOISE_PERSON_BIAS_H_

#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/camera.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/bias_learner.h"
#include "solvers/noise/bias_model.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

// Tells a series what the solution of a recording leaves, frame by frame in
// order.
class BiasObserver {
 public:
  // Measurements name `cameras`; errors last as `correlation` says. All but the
  // last argument are read as long as the observer lives.
  BiasObserver(const BiasJoints& joints, const CameraRig& cameras,
               double frame_rate_hz, const ErrorCorrelation& correlation,
               BiasSeries* series);
  // Frame `k` of `solved`, with the weights that the solver gave.
  void Add(const PersonProblem& solved, size_t k);

 private:
  std::vector<BiasView> ViewsOf(const PersonProblem& solved, size_t k,
                                int joint_idx, const BodyStance& stance) const;

  const BiasJoints& joints_;
  const CameraRig& cameras_;
  const TimeNs look_after_;
  const double independent_;  // what a look counts as
  BiasSeries* const series_;
  std::vector<BiasSums> sums_;  // of the frame that is looked at
  std::optional<TimeNs> looked_;
};

// Writes a bias to the pixels of a recording whose triangulated joints stand at
// their states; `bias` may have other joints than `joints`.
void WriteBias(const BiasJoints& joints, const ViewBias& bias,
               const std::vector<FrameRecord>& records,
               PersonProblem* recording);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_PERSON_BIAS_H_
