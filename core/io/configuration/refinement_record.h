// The record of clocks and covariances in a cameras.json that `track`,
// `calibrate` or `doctor` wrote, so that a later run can apply them.
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_REFINEMENT_RECORD_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_REFINEMENT_RECORD_H_

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace kinegraph {

// Names and units of the parameters of a camera and its clock: the first eleven
// entries of a CameraChange (solvers/cameras/camera_change.h). Lens terms are
// not recorded.
inline constexpr std::array<const char*, 11> kCameraParameterNames = {
    "rotation_x_rad", "rotation_y_rad", "rotation_z_rad",  "centre_x_m",
    "centre_y_m",     "centre_z_m",     "shift_x_px",      "shift_y_px",
    "log_focal",      "clock_offset_s", "clock_drift_s_s",
};

struct RefinementRecord {
  struct Camera {
    std::string name;
    double offset_s = 0.0;  // added to the capture time
    // [s/s]; drift * (capture time - clock_zero_s) is added, too.
    double drift = 0.0;
    // Estimated parameters: indices of kCameraParameterNames, ascending.
    std::vector<int> places;
  };
  double clock_zero_s = 0.0;
  std::vector<Camera> cameras;
  // Covariance of the parameters in `places` of all cameras, camera by camera,
  // in their units; empty if nothing was estimated.
  Eigen::MatrixXd covariance;

  bool has_clocks() const;
};

// nullopt if `path` is not a cameras.json with a record. Throws InputError for
// an unreadable record.
std::optional<RefinementRecord> ReadRefinementRecord(const std::string& path);

// The record's JSON text, to be written again with the same cameras
// (WriteCameras); empty if there is no record. Throws InputError for an
// unreadable record.
std::string RefinementText(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_REFINEMENT_RECORD_H_
