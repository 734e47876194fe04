// CMU Panoptic's JSON: {"cameras": [{"name": "00_03", "resolution": [w, h],
// "K": 3x3, "distCoef": [k1, k2, p1, p2, k3], "R": 3x3, "t": 3x1}, ...]}:
// x_cam = R X + t, centimetres.
#include "core/base/error.h"
#include "core/io/calibration_formats.h"

namespace kinegraph {

CalibrationFile ReadPanopticCameras(const JsonField& root) {
  CalibrationFile file;
  file.unit = LengthUnit::kCentimetre;
  for (const JsonField& element : root.At("cameras").Elements("camera")) {
    CameraRecord record;
    record.file = root.file();
    record.name = element.At("name").Text();
    const JsonField camera =
        element.Named("camera '" + Printable(record.name) + "'");
    if (const auto size = camera.Find("resolution")) {
      ReadImageSize(*size, &record);
    }
    record.K = ToMatrix3(camera.At("K").Matrix(3, 3));
    if (const auto lens = camera.Find("distCoef")) {
      record.distortion = lens->Numbers();
    }
    record.R = ToMatrix3(camera.At("R").Matrix(3, 3));
    record.t = ToVector3(camera.At("t").Matrix(3, 1));
    file.cameras.push_back(record);
  }
  return file;
}

}  // namespace kinegraph
