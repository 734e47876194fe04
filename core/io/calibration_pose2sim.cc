// TOML of Pose2Sim and Anipose, a table a camera: name, size [w, h], matrix
// 3x3 px, distortions [k1, k2, p1, p2(, k3)], rotation (Rodrigues vector,
// cam_from_world), translation (metres in Pose2Sim's files; Anipose's have the
// unit of the calibration board). The table "metadata" is no camera.
#include <fmt/format.h>

#include "core/base/error.h"
#include "core/io/calibration_formats.h"
#include "core/io/calibration_keys.h"
#include "core/io/calibration_write_formats.h"
#include "core/io/skeleton_json.h"

namespace kinegraph {

CalibrationFile ReadPose2simCameras(const JsonField& root) {
  CalibrationFile file;
  for (const auto& [table, field] : root.Members("camera")) {
    if (table == "metadata") continue;
    CameraRecord record;
    record.file = root.file();
    const auto name = field.Find("name");
    record.name = name.has_value() ? name->Text() : table;
    KeyReader camera(field.Named("camera '" + Printable(record.name) + "'"));
    if (const auto size = camera.Find("size")) ReadImageSize(*size, &record);
    record.K = ToMatrix3(camera.At("matrix").Matrix(3, 3));
    camera.ReadLens(&record);
    record.R = RotationOf(ToVector3(camera.At("rotation").Matrix(3, 1)));
    record.t = ToVector3(camera.At("translation").Matrix(3, 1));
    camera.RejectUnread();
    file.cameras.push_back(record);
  }
  return file;
}

std::string Pose2simCamerasText(const CameraRig& cameras) {
  std::string text;
  int number = 0;
  for (const Camera& camera : cameras) {
    const auto lens = OpenCvCoefficients(camera);
    const Eigen::Matrix3d& K = camera.K();
    text += fmt::format("[cam_{:02}]\n", ++number);
    // JSON's escapes are TOML's.
    text += "name = " + JsonText(camera.name()) + "\n";
    if (HasSize(camera)) {
      const Eigen::Vector2d size(camera.width_px(), camera.height_px());
      text += "size = " + DecimalList(size) + "\n";
    }
    text += "matrix = [" + DecimalList(K.row(0)) + ", " +
            DecimalList(K.row(1)) + ", " + DecimalList(K.row(2)) + "]\n";
    // Pose2Sim's own files have four coefficients; OpenCV takes k3 as fifth.
    const Eigen::Index count = lens[4] == 0.0 ? 4 : 5;
    text += "distortions = " + DecimalList(lens.head(count)) + "\n";
    text += "rotation = " + DecimalList(RotationVector(camera.R())) + "\n";
    text += "translation = " + DecimalList(camera.t()) + "\n";
    text += "fisheye = false\n\n";
  }
  return text + "[metadata]\nadjusted = false\nerror = 0.0\n";
}

}  // namespace kinegraph
