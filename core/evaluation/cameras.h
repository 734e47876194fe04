// Cameras against true ones.
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
  std::vector<CameraError> cameras;  // those in both, in the truth's order
  // Translation error (TE), the same scale-aligned, and angle error (AE): means
  // over the cameras.
  double te_m = 0.0;
  double scaled_te_m = 0.0;
  double ae_deg = 0.0;
  double scale = 1.0;  // true over found
  // Relative rotation accuracy: pairs of cameras whose rotation to each other
  // is nearer than 5, 10, 15 degrees to the true one; nothing is aligned.
  std::vector<double> rra_deg = {5.0, 10.0, 15.0};
  std::vector<Share> rra;
  // Camera centre accuracy: cameras nearer than 5, 10, 15 % of the scene's size
  // to the true one, that is the distance of the farthest true camera from
  // their mean; scale-aligned, and rigidly.
  std::vector<double> cca_percent = {5.0, 10.0, 15.0};
  std::vector<Share> scaled_cca, cca;
};

// Cameras of the same name. Worlds are aligned on the centres (Umeyama 1991);
// where these lie within a twentieth of their length about a line, or are two,
// they leave a turn about it open, and the mean of the cameras' rotations is
// taken instead. Throws InputError
// naming `path` and `truth_path` when fewer than two cameras are in both.
CameraResult EvaluateCameras(const CameraRig& truth,
                             const std::string& truth_path,
                             const CameraRig& cameras, const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_CAMERAS_H_
