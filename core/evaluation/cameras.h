// Errors of calibrated cameras relative to the true cameras.
#ifndef KINEGRAPH_CORE_EVALUATION_CAMERAS_H_
#define KINEGRAPH_CORE_EVALUATION_CAMERAS_H_

#include <string>
#include <vector>

#include "core/evaluation/statistics.h"
#include "core/geometry/camera.h"

namespace kinegraph {

struct CameraError {
  std::string name;
  double position_m = 0.0;         // after the rigid alignment
  double scaled_position_m = 0.0;  // after the alignment with scale
  double rotation_deg = 0.0;       // after the rigid alignment
};

struct CameraResult {
  std::vector<CameraError> cameras;  // in both rigs, in the truth's order
  // Cameras of the truth that were not estimated and are not scored.
  std::vector<std::string> missing;
  // Translation error (TE), the same after alignment with scale, and angle
  // error (AE): means over the cameras.
  double te_m = 0.0;
  double scaled_te_m = 0.0;
  double ae_deg = 0.0;
  double scale = 1.0;  // true over found
  // Relative rotation accuracy: pairs of cameras whose relative rotation is
  // within 5, 10, 15 degrees of the true one; needs no alignment.
  std::vector<double> rra_deg = {5.0, 10.0, 15.0};
  std::vector<Share> rra;
  // Camera centre accuracy: cameras whose centre is within 5, 10, 15 % of the
  // scene's size of the true one, after alignment with scale and after rigid
  // alignment. The size is the distance of the farthest of the scored true
  // cameras from their mean.
  std::vector<double> cca_percent = {5.0, 10.0, 15.0};
  std::vector<Share> scaled_cca, cca;
};

// Compares cameras of the same name. The worlds are aligned by the cameras'
// centres (Umeyama 1991). If the centres of either rig are nearly collinear
// (RMS extent along the second principal axis at most 5 % of that along the
// first, as for two cameras), the rotation about the line is undetermined, and
// the mean over the cameras of the rotation from the found to the true world is
// used instead. Throws InputError naming `path` and `truth_path` when fewer
// than two cameras are in both.
CameraResult EvaluateCameras(const CameraRig& truth,
                             const std::string& truth_path,
                             const CameraRig& cameras, const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_CAMERAS_H_
