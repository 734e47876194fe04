// {"0": {"K": 3x3 row-major, "RT": 3x4 row-major, "imgSize": [w, h]}, ...} as
// 4D association writes it: x_cam = R X + t, metres, pixels. It calls a lens
// "distCoeff"; any name that KeyReader::ReadLens knows will do.
#include "core/io/calibration/format.h"
#include "core/io/calibration/keys.h"
#include "core/io/calibration/write_formats.h"

namespace kinegraph {
namespace {

bool RecogniseKrt(const CalibrationHead& head) {
  return FirstMemberHas(head, {"RT"});
}

CalibrationFile ReadKrt(const CalibrationHead& head) {
  const JsonField root = head.Root();
  CalibrationFile file;
  KeyReader(root).ReadUnit(&file);
  ReadMembers(root, &file, [](KeyReader* camera, CameraRecord* record) {
    record->K = ToMatrix3(camera->At("K").Matrix(3, 3));
    const std::vector<double> numbers = camera->At("RT").Matrix(3, 4);
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> rt(
        numbers.data());
    record->R = rt.leftCols<3>();
    record->t = rt.col(3);
    if (const auto size = camera->Find("imgSize")) ReadImageSize(*size, record);
    camera->ReadLens(record);
  });
  return file;
}

void WriteKrt(const std::string& path, const CameraRig& cameras,
              LostFields* lost_fields) {
  NoteUnknownSizes(cameras, lost_fields);
  Json json = Json::object();
  for (const Camera& camera : cameras) {
    Eigen::Matrix<double, 3, 4> rt;
    rt << camera.R(), camera.t();
    Json entry = {{"K", JsonFlat(camera.K())}, {"RT", JsonFlat(rt)}};
    if (HasSize(camera)) {
      entry["imgSize"] = {camera.width_px(), camera.height_px()};
    }
    if (camera.lens() != nullptr) {
      entry["distCoeff"] = JsonFlat(OpenCvCoefficients(camera));
    }
    json[camera.name()] = entry;
  }
  WriteText(path, JsonLines(json));
}

}  // namespace

CalibrationFormat KrtCalibrationFormat() {
  CalibrationFormat format;
  format.name = "krt";
  format.layout = "JSON: K and RT of each camera";
  format.recognise = RecogniseKrt;
  format.read = ReadKrt;
  format.write = WriteKrt;
  format.kept = "everything, bit for bit; a lens as `distCoeff`";
  return format;
}

}  // namespace kinegraph
