// What the readers of single calibration formats hand to ReadCameras. For
// core/io alone.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_FORMATS_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_FORMATS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "core/io/text/json.h"

namespace kinegraph {

// One camera in the words of its file: nothing is checked yet but shapes and
// that numbers are finite.
struct CameraRecord {
  std::string file;  // for messages
  std::string name;
  int64_t width_px = 0;  // 0: not told
  int64_t height_px = 0;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  // K belongs to coordinates divided by the image size.
  bool normalised_K = false;
  // The size is that of the sensor: a picture of another size and the same
  // proportions (cameras.image_size) is the whole of it, scaled.
  bool may_be_scaled = false;
  std::string lens_model = "opencv5";
  std::vector<double> distortion;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // cam_from_world
  // cam_from_world, in the file's unit; meaningless when `centre` is given.
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  // Position of the camera in the world, in the file's unit.
  std::optional<Eigen::Vector3d> centre;
};

struct CalibrationFile {
  std::vector<CameraRecord> cameras;
  LengthUnit unit = LengthUnit::kMetre;  // the format's own
  bool states_unit = false;              // it cannot be another one
};

// Whether P0.txt, P1.txt, ... are among the names of a folder's files.
bool HasTumFiles(const std::vector<std::string>& names);

// Two whole numbers: width and height.
void ReadImageSize(const JsonField& field, CameraRecord* record);
// Row-major numbers as a matrix.
Eigen::Matrix3d ToMatrix3(const std::vector<double>& row_major);
Eigen::Vector3d ToVector3(const std::vector<double>& numbers);
// Rotation by |vector| radians about its direction (Rodrigues).
Eigen::Matrix3d RotationOf(const Eigen::Vector3d& vector);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_FORMATS_H_
