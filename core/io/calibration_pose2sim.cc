// TOML of Pose2Sim and Anipose, a table a camera: name, size [w, h], matrix
// 3x3 px, distortions [k1, k2, p1, p2(, k3)], rotation (Rodrigues vector,
// cam_from_world), translation (metres in Pose2Sim's files; Anipose's have the
// unit of the calibration board). The table "metadata" is no camera.
#include "core/base/error.h"
#include "core/io/calibration_formats.h"

namespace kinegraph {

CalibrationFile ReadPose2simCameras(const JsonField& root) {
  CalibrationFile file;
  for (const auto& [table, field] : root.Members("camera")) {
    if (table == "metadata") continue;
    CameraRecord record;
    record.file = root.file();
    const auto name = field.Find("name");
    record.name = name.has_value() ? name->Text() : table;
    const JsonField camera =
        field.Named("camera '" + Printable(record.name) + "'");
    const auto fisheye = camera.Find("fisheye");
    if (fisheye.has_value() && fisheye->Boolean()) {
      fisheye->Fail("found true: fisheye lenses are not supported");
    }
    if (const auto size = camera.Find("size")) ReadImageSize(*size, &record);
    record.K = ToMatrix3(camera.At("matrix").Matrix(3, 3));
    if (const auto lens = camera.Find("distortions")) {
      record.distortion = lens->Numbers();
    }
    record.R = RotationOf(ToVector3(camera.At("rotation").Matrix(3, 1)));
    record.t = ToVector3(camera.At("translation").Matrix(3, 1));
    file.cameras.push_back(record);
  }
  return file;
}

}  // namespace kinegraph
