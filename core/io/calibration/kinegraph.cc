// Our own cameras.json:
//   {"kinegraph_cameras": 1, "units": {"length": "m"}, "cameras": [
//     {"name": "cam0", "image_size": [w, h] or null, "model": "opencv5",
//      "K": 3x3 px, "distortion": [k1, k2, p1, p2, k3],
//      "cam_from_world": {"R": 3x3, "t": [x, y, z]}}, ...],
//    "refinement": {...}}  what `track` changed, if it did
// (refinement_record.h)
#include "core/base/error.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/keys.h"
#include "core/io/calibration/tracked_cameras.h"
#include "core/io/calibration/write_formats.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/side_files.h"

namespace kinegraph {
namespace {

Json ToJson(const Camera& camera) {
  const bool has_size = camera.width_px() > 0 && camera.height_px() > 0;
  const bool has_lens = camera.lens() != nullptr;
  const Eigen::Vector3d& t = camera.t();
  Json json;
  json["name"] = camera.name();
  json["image_size"] =
      has_size ? Json({camera.width_px(), camera.height_px()}) : Json(nullptr);
  json["model"] = has_lens ? camera.lens()->model() : "pinhole";
  json["K"] = JsonRows(camera.K());
  json["distortion"] =
      has_lens ? Json(camera.lens()->parameters()) : Json::array();
  json["cam_from_world"] = {{"R", JsonRows(camera.R())},
                            {"t", {t.x(), t.y(), t.z()}}};
  return json;
}

CameraRecord ReadKinegraphCamera(const JsonField& field) {
  CameraRecord record;
  record.file = field.file();
  record.name = field.At("name").Text();
  KeyReader camera(field.Named("camera '" + Printable(record.name) + "'"));
  const auto size = camera.Find("image_size");
  if (size.has_value() && !size->value().is_null()) {
    ReadImageSize(*size, &record);
  }
  record.K = ToMatrix3(camera.At("K").Matrix(3, 3));
  if (const auto model = camera.Find("model"))
    record.lens_model = model->Text();
  if (const auto lens = camera.Find("distortion")) {
    record.distortion = lens->Numbers();
  }
  KeyReader pose(camera.At("cam_from_world"));
  record.R = ToMatrix3(pose.At("R").Matrix(3, 3));
  record.t = ToVector3(pose.At("t").Matrix(3, 1));
  pose.RejectUnread();
  camera.RejectUnread();
  return record;
}

bool RecogniseKinegraph(const CalibrationHead& head) {
  return head.HasJsonKey("kinegraph_cameras");
}

CalibrationFile ReadKinegraph(const CalibrationHead& head) {
  KeyReader root(head.Root());
  const JsonField version = root.At("kinegraph_cameras");
  if (version.Integer() != 1) version.FailExpected("version 1");
  if (const auto units = root.Find("units")) {
    const JsonField length = units->At("length");
    if (length.Text() != "m") length.FailExpected("'m'");
  }
  CalibrationFile file;
  file.states_unit = true;
  for (const JsonField& camera : root.At("cameras").Elements("camera")) {
    file.cameras.push_back(ReadKinegraphCamera(camera));
  }
  root.Find("refinement");     // how the cameras came about
  root.Find(kFingerprintKey);  // of the tracks that they came with
  root.RejectUnread();
  return file;
}

void WriteKinegraph(const std::string& path, const CameraRig& cameras,
                    LostFields* /*losses*/) {
  WriteCameras(path, cameras);
}

}  // namespace

CalibrationFormat KinegraphCalibrationFormat() {
  CalibrationFormat format;
  format.name = "kinegraph";
  format.layout = "cameras.json";
  format.recognise = RecogniseKinegraph;
  format.read = ReadKinegraph;
  format.write = WriteKinegraph;
  format.kept = "everything, bit for bit";
  return format;
}

void WriteCameras(const std::string& path, const CameraRig& cameras,
                  const std::string& refinement) {
  WriteTrackedCameras(path, cameras, refinement, "");
}

void WriteTrackedCameras(const std::string& path, const CameraRig& cameras,
                         const std::string& refinement,
                         const std::string& tracks) {
  AtomicFile file(path);
  file.Write(
      WithFingerprint("{\"kinegraph_cameras\": 1, \"units\": "
                      "{\"length\": \"m\"}, \"cameras\": [",
                      tracks));
  const char* separator = "\n";
  for (const Camera& camera : cameras) {
    // A name that is not UTF-8 is written with replacement characters.
    file.Write(separator + DumpJson(ToJson(camera)));
    separator = ",\n";
  }
  file.Write("\n]");
  if (!refinement.empty()) file.Write(",\n\"refinement\": " + refinement);
  file.Write("}\n");
  file.Commit();
}

}  // namespace kinegraph
