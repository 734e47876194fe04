// Corrections of a camera and its clock relative to the calibration.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_CAMERA_CHANGE_H_
#define KINEGRAPH_SOLVERS_CAMERAS_CAMERA_CHANGE_H_

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/camera.h"

namespace kinegraph {

// Indices of a change's parameters. Each begins a block; its comment begins
// with the size of the block.
inline constexpr int kRotationAt = 0;  // 3 [rad], about the camera's axes
inline constexpr int kCentreAt = 3;    // 3 [m], in the world
inline constexpr int kShiftAt = 6;     // 2 [px], in the image
inline constexpr int kFocalAt = 8;     // 1, logarithm of the factor
inline constexpr int kOffsetAt = 9;    // 1 [s], added to the capture time
inline constexpr int kDriftAt = 10;    // 1 [s/s], times the time since the
                                       // middle of the recording
inline constexpr int kLensAt = 11;     // 1, added to the lens's k1
inline constexpr int kLensK2At = 12;   // 1, added to the lens's k2
inline constexpr int kChangeSize = 13;

// Zero leaves the stated calibration unchanged. exp(rotation) is applied after
// the stated rotation; the centre is displaced in the world; the first two
// radial terms of the lens change; the image is scaled about the principal
// point and then shifted.
using CameraChange = Eigen::Matrix<double, kChangeSize, 1>;

// One zero change per camera.
inline std::vector<CameraChange> NoChanges(size_t cameras) {
  return std::vector<CameraChange>(cameras, CameraChange::Zero());
}

// v x w = CrossMatrix(v) w.
Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v);

// Rotation by |vector| radians about its direction.
Eigen::Matrix3d ExpRotation(const Eigen::Vector3d& vector);

// Raw pixel of a point in `camera` after the change, without its clock. nullopt
// as for Camera::Project, and where the change of the lens alone would move
// points nearer to the image's centre the farther they are from the axis. The
// Jacobians with respect to the point (2x3, px/m) and the change (2 x
// kChangeSize; zero for the clock) may be null.
std::optional<Eigen::Vector2d> ProjectChanged(
    const Camera& camera, const CameraChange& change,
    const Eigen::Vector3d& point_m, Matrix23d* by_point = nullptr,
    Eigen::Matrix<double, 2, kChangeSize>* by_change = nullptr);

// A copy of a camera, or of all cameras of a rig, with its parameters edited.
template <typename Edit>
Camera Edited(const Camera& camera, const Edit& edit) {
  CameraParameters parameters = camera.parameters();
  edit(&parameters);
  return Camera(std::move(parameters));
}
template <typename Edit>
CameraRig Edited(const CameraRig& cameras, const Edit& edit) {
  CameraRig edited;
  for (const Camera& camera : cameras) edited.push_back(Edited(camera, edit));
  return edited;
}

// The camera after the change.
Camera ChangedCamera(const Camera& camera, const CameraChange& change);

// The cameras after their changes.
CameraRig RefinedCameras(const CameraRig& cameras,
                         const std::vector<CameraChange>& changes);

// The cameras in a world scaled by `factor`.
CameraRig Rescaled(const CameraRig& cameras, double factor);

// Scales the centres by `factor` in the covariance of the changes at `places`
// (one list per view).
void RescaleCentres(const std::vector<std::vector<int>>& places, double factor,
                    Eigen::MatrixXd* covariance);

// The parameters to estimate.
struct FreeParameters {
  bool rotation = false;
  bool centre = false;
  bool shift = false;
  bool focal = false;
  bool lens = false;  // k1
  bool lens_k2 = false;
  bool offset = false;
  bool drift = false;

  // The parameters whose first index in a CameraChange is among `places`.
  static FreeParameters At(const std::vector<int>& places);
  // Indices in a CameraChange, ascending.
  std::vector<int> Places() const;
  bool any_camera() const {
    return rotation || centre || shift || focal || lens || lens_k2;
  }
};

// Clock parameters that a recording of this length determines: the offset and,
// if 100 ppm amount to more than two milliseconds, the drift.
FreeParameters ClockParametersOf(double span_s);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_CAMERA_CHANGE_H_
