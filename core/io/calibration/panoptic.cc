// CMU Panoptic's JSON: {"cameras": [{"name": "00_03", "resolution": [w, h],
// "K": 3x3, "distCoef": [k1, k2, p1, p2, k3], "R": 3x3, "t": 3x1}, ...]}:
// x_cam = R X + t, centimetres.
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/keys.h"
#include "core/io/calibration/write_formats.h"

namespace kinegraph {
namespace {

bool RecognisePanoptic(const CalibrationHead& head) {
  return head.HasJsonKey("cameras") && !head.HasJsonKey("kinegraph_cameras") &&
         head.json["cameras"].is_array();
}

CalibrationFile ReadPanoptic(const CalibrationHead& head) {
  const JsonField root = head.Root();
  CalibrationFile file;
  file.unit = LengthUnit::kCentimetre;
  KeyReader keys(root);
  keys.ReadUnit(&file);
  for (const JsonField& element : keys.At("cameras").Elements("camera")) {
    CameraRecord record;
    record.file = root.file();
    record.name = element.At("name").Text();
    KeyReader camera(element.Named("camera '" + Printable(record.name) + "'"));
    if (const auto size = camera.Find("resolution")) {
      ReadImageSize(*size, &record);
    }
    record.K = ToMatrix3(camera.At("K").Matrix(3, 3));
    camera.ReadLens(&record);
    record.R = ToMatrix3(camera.At("R").Matrix(3, 3));
    record.t = ToVector3(camera.At("t").Matrix(3, 1));
    camera.RejectUnread();
    file.cameras.push_back(record);
  }
  keys.RejectUnread();
  return file;
}

void WritePanoptic(const std::string& path, const CameraRig& cameras,
                   LostFields* lost_fields) {
  NoteUnknownSizes(cameras, lost_fields);
  Json list = Json::array();
  for (const Camera& camera : cameras) {
    const Eigen::Vector3d t_cm = kCentimetresPerMetre * camera.t();
    Json entry = {{"name", camera.name()}, {"type", "hd"}};
    if (HasSize(camera)) {
      entry["resolution"] = {camera.width_px(), camera.height_px()};
    }
    entry["K"] = JsonRows(camera.K());
    entry["distCoef"] = JsonFlat(OpenCvCoefficients(camera));
    entry["R"] = JsonRows(camera.R());
    entry["t"] = JsonRows(t_cm);
    list.push_back(entry);
  }
  WriteText(path, JsonLines(Json{{"cameras", list}}));
}

}  // namespace

CalibrationFormat PanopticCalibrationFormat() {
  CalibrationFormat format;
  format.name = "panoptic";
  format.layout = "CMU Panoptic's JSON, cm";
  format.recognise = RecognisePanoptic;
  format.read = ReadPanoptic;
  format.write = WritePanoptic;
  format.kept = "everything; cm, so the last bit of `t` may change";
  return format;
}

}  // namespace kinegraph
