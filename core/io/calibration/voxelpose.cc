// VoxelPose's JSON: {"0": {"R": 3x3, "T": 3x1, "fx", "fy", "cx", "cy",
// "k": 3x1, "p": 2x1}, ...}, millimetres. T is the camera's centre:
// x_cam = R (X - T). Radial k1 k2 k3 and tangential p1 p2.
#include "core/base/constants.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/keys.h"
#include "core/io/calibration/write_formats.h"

namespace kinegraph {
namespace {

bool RecogniseVoxelpose(const CalibrationHead& head) {
  return FirstMemberHas(head, {"T", "fx"}) && !FirstMemberHas(head, {"RT"});
}

CalibrationFile ReadVoxelpose(const CalibrationHead& head) {
  const JsonField root = head.Root();
  CalibrationFile file;
  file.unit = LengthUnit::kMillimetre;
  KeyReader(root).ReadUnit(&file);
  ReadMembers(root, &file, [](KeyReader* camera, CameraRecord* record) {
    // Read before they are put in: Eigen asserts that a list which has begun
    // comes to its end, also when one of them throws.
    const double fx = camera->At("fx").Number();
    const double fy = camera->At("fy").Number();
    const double cx = camera->At("cx").Number();
    const double cy = camera->At("cy").Number();
    record->K << fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0;
    record->R = ToMatrix3(camera->At("R").Matrix(3, 3));
    record->centre = ToVector3(camera->At("T").Matrix(3, 1));
    camera->ReadLens(record);
  });
  return file;
}

void WriteVoxelpose(const std::string& path, const CameraRig& cameras,
                    LostFields* lost_fields) {
  Json json = Json::object();
  bool has_size = false;
  for (const Camera& camera : cameras) {
    const Eigen::Matrix3d& K = camera.K();
    CheckSkew(camera);
    const auto lens = OpenCvCoefficients(camera);
    const Eigen::Vector3d radial(lens[0], lens[1], lens[4]);
    const Eigen::Vector2d tangential(lens[2], lens[3]);
    const Eigen::Vector3d centre_mm = kMillimetresPerMetre * camera.centre();
    json[camera.name()] = {{"R", JsonRows(camera.R())},
                           {"T", JsonRows(centre_mm)},
                           {"fx", K(0, 0)},
                           {"fy", K(1, 1)},
                           {"cx", K(0, 2)},
                           {"cy", K(1, 2)},
                           {"k", JsonRows(radial)},
                           {"p", JsonRows(tangential)}};
    has_size = has_size || HasSize(camera);
  }
  if (has_size) lost_fields->push_back("image sizes are not kept");
  NoteSkew(cameras, lost_fields);
  WriteText(path, JsonLines(json));
}

}  // namespace

CalibrationFormat VoxelposeCalibrationFormat() {
  CalibrationFormat format;
  format.name = "voxelpose";
  format.layout = "JSON, mm";
  format.recognise = RecogniseVoxelpose;
  format.read = ReadVoxelpose;
  format.write = WriteVoxelpose;
  format.kept = "K, lens, pose; t through the camera centre, to 1e-14";
  format.lost =
      "lost: image sizes, a skew that is rounding (0.01 px); refused: a skewed "
      "K";
  return format;
}

}  // namespace kinegraph
