// JSON of longcw's crossview data: {"cameras": {"Camera0": {"K": 3x3,
// "Tw": 4x4, "dist_coeffs": [k1, k2, p1, p2]}, ...}}. K belongs to coordinates
// divided by the image's width and height; Tw is world_from_cam, centimetres.
#include "core/io/calibration_formats.h"

namespace kinegraph {

CalibrationFile ReadLongcwCameras(const JsonField& root) {
  CalibrationFile file;
  file.unit = LengthUnit::kCentimetre;
  for (const auto& [name, camera] : root.At("cameras").Members("camera")) {
    CameraRecord record;
    record.file = root.file();
    record.name = name;
    record.K = ToMatrix3(camera.At("K").Matrix(3, 3));
    record.normalised_K = true;
    const JsonField pose = camera.At("Tw");
    const std::vector<double> numbers = pose.Matrix(4, 4);
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>
        world_from_cam(numbers.data());
    if (world_from_cam.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)) {
      pose.Fail("the last row is not 0 0 0 1");
    }
    record.R = world_from_cam.topLeftCorner<3, 3>().transpose();
    record.centre = world_from_cam.topRightCorner<3, 1>();
    if (const auto lens = camera.Find("dist_coeffs")) {
      record.distortion = lens->Numbers();
    }
    file.cameras.push_back(record);
  }
  return file;
}

}  // namespace kinegraph
