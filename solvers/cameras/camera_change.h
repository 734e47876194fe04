// How a camera or its clock differs from what the calibration states.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_CAMERA_CHANGE_H_
#define KINEGRAPH_SOLVERS_CAMERAS_CAMERA_CHANGE_H_

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/camera.h"

namespace kinegraph {

// Places of a change's parameters in a vector; each begins a block.
inline constexpr int kRotationAt = 0;  // 3 [rad], about the camera's own axes
inline constexpr int kCentreAt = 3;    // 3 [m], in the world
inline constexpr int kShiftAt = 6;     // 2 [px], on the image
inline constexpr int kFocalAt = 8;     // 1, logarithm of the factor
inline constexpr int kOffsetAt = 9;    // 1 [s], added to the time of capture
inline constexpr int kDriftAt = 10;    // 1 [s/s], of the time in the recording
inline constexpr int kLensAt = 11;     // 1, added to the lens' k1
inline constexpr int kChangeSize = 12;

// All zero: the calibration is right. Ideal rays are turned by exp(rotation)
// after the stated rotation; the centre moves in the world; the lens gets
// another first radial term; the image is magnified about the principal point
// and then shifted.
using CameraChange = Eigen::Matrix<double, kChangeSize, 1>;

// Of each camera of a rig.
inline std::vector<CameraChange> NoChanges(size_t cameras) {
  return std::vector<CameraChange>(cameras, CameraChange::Zero());
}

// v x w = CrossMatrix(v) w.
Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v);

// Rotation by |vector| radians about its direction.
Eigen::Matrix3d ExpRotation(const Eigen::Vector3d& vector);

// Raw pixel of a point in the camera that the change makes of `camera` (clock
// aside). nullopt as Camera::Project. The Jacobians may be null: by the point
// (2x3, px/m) and by the change (2 x kChangeSize; zero for the clock).
std::optional<Eigen::Vector2d> ProjectChanged(
    const Camera& camera, const CameraChange& change,
    const Eigen::Vector3d& point_m, Matrix23d* by_point = nullptr,
    Eigen::Matrix<double, 2, kChangeSize>* by_change = nullptr);

// A camera with what `edit` changes in its parameters; all cameras of a rig.
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

// The camera itself.
Camera ChangedCamera(const Camera& camera, const CameraChange& change);

// The cameras with their changes.
CameraRig RefinedCameras(const CameraRig& cameras,
                         const std::vector<CameraChange>& changes);

// The cameras in a world whose lengths are so many times as large.
CameraRig Rescaled(const CameraRig& cameras, double factor);

// The same of a covariance of changes at `places`, one list a view.
void RescaleCentres(const std::vector<std::vector<int>>& places, double factor,
                    Eigen::MatrixXd* covariance);

// Which parameters are estimated.
struct FreeParameters {
  bool rotation = false;
  bool centre = false;
  bool shift = false;
  bool focal = false;
  bool lens = false;
  bool offset = false;
  bool drift = false;

  // Those at any of the places of a CameraChange.
  static FreeParameters At(const std::vector<int>& places);
  // Places in a CameraChange, ascending.
  std::vector<int> Places() const;
  bool any_camera() const {
    return rotation || centre || shift || focal || lens;
  }
};

// A clock as it can be told from a recording of this length: its offset, and
// its drift where 100 ppm of it are two milliseconds.
FreeParameters ClockParametersOf(double span_s);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_CAMERA_CHANGE_H_
