// JSON of longcw's crossview data: {"cameras": {"Camera0": {"K": 3x3,
// "Tw": 4x4, "dist_coeffs": [k1, k2, p1, p2]}, ...}}. K belongs to coordinates
// divided by the image's width and height; Tw is world_from_cam, centimetres.
#include "core/base/constants.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/keys.h"
#include "core/io/calibration/write_formats.h"

namespace kinegraph {
namespace {

bool RecogniseLongcw(const CalibrationHead& head) {
  return head.HasJsonKey("cameras") && !head.HasJsonKey("kinegraph_cameras") &&
         FirstMemberHas(head.json["cameras"], {"Tw"});
}

CalibrationFile ReadLongcw(const CalibrationHead& head) {
  const JsonField root = head.Root();
  CalibrationFile file;
  file.unit = LengthUnit::kCentimetre;
  KeyReader keys(root);
  keys.ReadUnit(&file);
  ReadMembers(
      keys.At("cameras"), &file, [](KeyReader* camera, CameraRecord* record) {
        record->K = ToMatrix3(camera->At("K").Matrix(3, 3));
        record->normalised_K = true;
        const JsonField pose = camera->At("Tw");
        const std::vector<double> numbers = pose.Matrix(4, 4);
        const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>
            world_from_cam(numbers.data());
        if (world_from_cam.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)) {
          pose.Fail("the last row is not 0 0 0 1");
        }
        record->R = world_from_cam.topLeftCorner<3, 3>().transpose();
        record->centre = world_from_cam.topRightCorner<3, 1>();
        camera->ReadLens(record);
      });
  keys.RejectUnread();
  return file;
}

// K is divided by the image size, which the file does not tell: a reader is
// told one size for all cameras.
void WriteLongcw(const std::string& path, const CameraRig& cameras,
                 LostFields* lost_fields) {
  Json members = Json::object();
  for (const Camera& camera : cameras) {
    if (!HasSize(camera)) {
      throw CannotWrite(camera,
                        "longcw's K is divided by the image size, which the "
                        "input does not tell (--image_size=W,H)");
    }
    if (camera.width_px() != cameras[0].width_px() ||
        camera.height_px() != cameras[0].height_px()) {
      throw CannotWrite(camera,
                        "has another image size than the first camera, which "
                        "longcw's format cannot say");
    }
    Eigen::Matrix3d K = camera.K();
    K.row(0) /= camera.width_px();
    K.row(1) /= camera.height_px();
    Eigen::Matrix4d world_from_cam = Eigen::Matrix4d::Identity();
    world_from_cam.topLeftCorner<3, 3>() = camera.R().transpose();
    world_from_cam.topRightCorner<3, 1>() =
        kCentimetresPerMetre * camera.centre();
    members[camera.name()] = {
        {"K", JsonRows(K)},
        {"Tw", JsonRows(world_from_cam)},
        {"dist_coeffs", JsonFlat(OpenCvCoefficients(camera))}};
  }
  if (!cameras.empty()) {
    lost_fields->push_back(
        "the image size is not kept: name it when reading "
        "(--image_size=" +
        std::to_string(cameras[0].width_px()) + "," +
        std::to_string(cameras[0].height_px()) + ")");
  }
  WriteText(path, JsonLines(Json{{"cameras", members}}));
}

}  // namespace

CalibrationFormat LongcwCalibrationFormat() {
  CalibrationFormat format;
  format.name = "longcw";
  format.layout = "JSON, cm";
  format.recognise = RecogniseLongcw;
  format.read = ReadLongcw;
  format.write = WriteLongcw;
  format.kept = "K, lens, pose; t through the camera centre and cm, to 1e-14";
  format.lost =
      "lost: the image size, by which K is divided (`--image_size` when "
      "reading); refused: cameras of unknown or different image sizes";
  return format;
}

}  // namespace kinegraph
