// Which single cameras and clocks explain what the matches do not fit.
#ifndef KINEGRAPH_SOLVERS_SCENE_EXPLAIN_RESIDUALS_H_
#define KINEGRAPH_SOLVERS_SCENE_EXPLAIN_RESIDUALS_H_

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "solvers/scene/doctor.h"

namespace kinegraph {

struct ExplainedRecording {
  const CameraRig& cameras;
  const SceneSegments& segments;
  const std::set<size_t>& strangers;  // views of which nothing is said
  std::vector<std::string> names;     // of the cameras
  double frame_rate_hz = 0.0;
  double subject_m = 1.7;  // size of the bodies
};

// Fits one kind of fault after the other (a clock, a shifted image, a turned
// camera, another focal length or lens) to one half of the recording and
// measures it on the other, adds what explains most to `findings`, and returns
// the changes taken.
//
// A late clock of a camera that looks at one walking person is a shifted image:
// clocks and cameras compete. What explains most goes first; the other may
// explain what is left.
std::vector<CameraChange> ExplainResiduals(const ExplainedRecording& recording,
                                           const BundleOptions& options,
                                           std::vector<CameraChange> start,
                                           std::vector<Finding>* findings);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_EXPLAIN_RESIDUALS_H_
