// What the readers of single calibration formats hand to ReadCameras. For
// core/io alone.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_FORMATS_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_FORMATS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/io/calibration.h"
#include "core/io/json.h"

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

// JSON formats; `root` is the whole file.
CalibrationFile ReadKinegraphCameras(const JsonField& root);
CalibrationFile ReadKrtCameras(const JsonField& root);
CalibrationFile ReadVoxelposeCameras(const JsonField& root);
CalibrationFile ReadLongcwCameras(const JsonField& root);
CalibrationFile ReadPanopticCameras(const JsonField& root);
// TOML, turned to JSON.
CalibrationFile ReadPose2simCameras(const JsonField& root);
// A folder of P*.txt or one such file.
CalibrationFile ReadTumCameras(const std::string& path);
// A folder of YAML files, one a camera, or one such file.
CalibrationFile ReadOpencvCameras(const std::string& path);
// The folder of intri.yml and extri.yml, one of the two, or one file with the
// content of both.
CalibrationFile ReadEasymocapCameras(const std::string& path);

// What a YAML file or folder of such files holds: kOpencv, kEasymocap or, for
// neither, kAuto.
CalibrationFormat DetectYamlFormat(const std::string& path);
// Names of P*.txt in a folder, by number.
std::vector<std::string> ListTumFiles(const std::string& folder);
// Whether a text consists of numbers, separated by spaces or commas.
bool IsNumberTable(const std::string& text);

// Two whole numbers: width and height.
void ReadImageSize(const JsonField& field, CameraRecord* record);
// Row-major numbers as a matrix.
Eigen::Matrix3d ToMatrix3(const std::vector<double>& row_major);
Eigen::Vector3d ToVector3(const std::vector<double>& numbers);
// Rotation by |vector| radians about its direction (Rodrigues).
Eigen::Matrix3d RotationOf(const Eigen::Vector3d& vector);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_FORMATS_H_
