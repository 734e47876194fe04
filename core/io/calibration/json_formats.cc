// Calibrations in JSON: kinegraph's own format and the formats of 4D
// association, VoxelPose, longcw and CMU Panoptic.
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/data/checks.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/tracked_cameras.h"
#include "core/io/calibration/write_formats.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/side_files.h"

namespace kinegraph {
namespace {

// Whether the first member that is an object has all of these keys: texts and
// numbers beside the cameras, such as a unit, are skipped.
bool FirstMemberHas(const Json& json, const std::vector<const char*>& keys) {
  if (!json.is_object()) return false;
  const auto first =
      std::find_if(json.begin(), json.end(),
                   [](const Json& one) { return one.is_object(); });
  if (first == json.end()) return false;
  return std::all_of(keys.begin(), keys.end(), [&first](const char* key) {
    return first->contains(key);
  });
}

bool FirstMemberHas(const CalibrationHead& head,
                    const std::vector<const char*>& keys) {
  return head.Is(CalibrationSyntax::kJson) && !head.HasJsonKey("cameras") &&
         !head.HasJsonKey("kinegraph_cameras") &&
         FirstMemberHas(head.json, keys);
}

// Whether the file has the key "cameras" but is not in kinegraph's own format.
bool HasOthersCameras(const CalibrationHead& head) {
  return head.HasJsonKey("cameras") && !head.HasJsonKey("kinegraph_cameras");
}

// ---- kinegraph's own ----
// cameras.json:
//   {"kinegraph_cameras": 1, "units": {"length": "m"}, "cameras": [
//     {"name": "cam0", "image_size": [w, h] or null, "model": "opencv5",
//      "K": 3x3 px, "distortion": [k1, k2, p1, p2, k3],
//      "cam_from_world": {"R": 3x3, "t": [x, y, z]}}, ...],
//    "refinement": {...}}
// "model" is "pinhole" (no coefficients), "opencv5" or "opencv_fisheye" (k1 k2
// k3 k4). "refinement" (optional) records how cameras were changed
// (refinement_record.h). A file beside tracks also names them, by the key
// kFingerprintKey (side_files.h).

Json CameraJson(const Camera& camera) {
  const bool has_lens = camera.lens() != nullptr;
  const Eigen::Vector3d& t = camera.t();
  Json json;
  json["name"] = camera.name();
  json["image_size"] = HasSize(camera)
                           ? Json({camera.width_px(), camera.height_px()})
                           : Json(nullptr);
  json["model"] = has_lens ? camera.lens()->model() : "pinhole";
  json["K"] = JsonRows(camera.K());
  json["distortion"] =
      has_lens ? Json(camera.lens()->parameters()) : Json::array();
  json["cam_from_world"] = {{"R", JsonRows(camera.R())},
                            {"t", {t.x(), t.y(), t.z()}}};
  return json;
}

void ReadKinegraphCamera(KeyReader* camera, CameraRecord* record) {
  camera->ReadImageSize("image_size", record);
  record->K = camera->Matrix3("K");
  if (const auto model = camera->Find("model")) {
    record->lens_model = model->Text();
  }
  if (const auto lens = camera->Find("distortion")) {
    record->distortion = lens->Numbers();
  }
  KeyReader pose(camera->At("cam_from_world"));
  record->R = pose.Matrix3("R");
  record->t = pose.Vector3("t");
  pose.RejectUnread();
}

}  // namespace

bool RecogniseKinegraph(const CalibrationHead& head) {
  return head.HasJsonKey("kinegraph_cameras");
}

CalibrationFile ReadKinegraph(const CalibrationHead& head) {
  KeyReader root(head.Root());
  const JsonField version = root.At("kinegraph_cameras");
  if (version.Integer() != 1) version.FailExpected("version 1");
  CalibrationFile file;
  file.states_unit = true;
  if (const auto units = root.Find("units")) {
    const std::map<std::string, LengthUnit> known = {
        {"m", LengthUnit::kMetre},
        {"cm", LengthUnit::kCentimetre},
        {"mm", LengthUnit::kMillimetre}};
    const JsonField length = units->At("length");
    const auto unit = known.find(length.Text());
    if (unit == known.end()) length.FailExpected("'m', 'cm' or 'mm'");
    file.unit = unit->second;
  }
  for (const JsonField& camera : root.At("cameras").Elements("camera")) {
    file.cameras.push_back(
        ReadNamed(camera, camera.At("name").Text(), ReadKinegraphCamera));
  }
  root.Find("refinement");     // how the cameras were changed
  root.Find(kFingerprintKey);  // of the tracks to which the cameras belong
  root.RejectUnread();
  return file;
}

CalibrationFile ReadByAdapter(const Adapter& adapter, const std::string& path) {
  CalibrationHead head;
  head.path = path;
  head.json = ParseJson(OutputOf(adapter, path), path);
  CalibrationFile file = ReadKinegraph(head);
  file.states_unit = false;  // the adapter states the unit, not the file
  return file;
}

void WriteKinegraph(const std::string& path, const CameraRig& cameras,
                    LostFields* /*losses*/) {
  WriteCameras(path, cameras);
}

void WriteCameras(const std::string& path, const CameraRig& cameras,
                  const std::string& refinement) {
  WriteTrackedCameras(path, cameras, refinement, "");
}

void WriteTrackedCameras(const std::string& path, const CameraRig& cameras,
                         const std::string& refinement,
                         const std::string& tracks) {
  CheckCameraNames(cameras);
  AtomicFile file(path);
  file.Write(
      WithFingerprint("{\"kinegraph_cameras\": 1, \"units\": "
                      "{\"length\": \"m\"}, \"cameras\": [",
                      tracks));
  const char* separator = "\n";
  for (const Camera& camera : cameras) {
    // Names that are not UTF-8 are written with replacement characters.
    file.Write(separator + DumpJson(CameraJson(camera)));
    separator = ",\n";
  }
  file.Write("\n]");
  if (!refinement.empty()) file.Write(",\n\"refinement\": " + refinement);
  file.Write("}\n");
  file.Commit();
}

// ---- 4D association ----
// {"0": {"K": 3x3 row-major, "RT": 3x4 row-major, "imgSize": [w, h]}, ...} as
// 4D association writes it: x_cam = R X + t, metres, pixels. Its key for the
// lens is "distCoeff"; every name that KeyReader::ReadLens knows is accepted.

bool RecogniseKrt(const CalibrationHead& head) {
  return FirstMemberHas(head, {"RT"});
}

CalibrationFile ReadKrt(const CalibrationHead& head) {
  const JsonField root = head.Root();
  CalibrationFile file;
  KeyReader(root).ReadUnit(&file);
  ReadMembers(root, &file, [](KeyReader* camera, CameraRecord* record) {
    record->K = camera->Matrix3("K");
    const std::vector<double> numbers = camera->At("RT").Matrix(3, 4);
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> rt(
        numbers.data());
    record->R = rt.leftCols<3>();
    record->t = rt.col(3);
    camera->ReadImageSize("imgSize", record);
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
    Json entry = {{"K", RowMajor(camera.K())}, {"RT", RowMajor(rt)}};
    if (HasSize(camera)) {
      entry["imgSize"] = {camera.width_px(), camera.height_px()};
    }
    if (camera.lens() != nullptr) {
      entry["distCoeff"] = RowMajor(OpenCvCoefficients(camera));
    }
    json[camera.name()] = entry;
  }
  WriteTextFile(path, JsonLines(json));
}

// ---- VoxelPose ----
// {"0": {"R": 3x3, "T": 3x1, "fx", "fy", "cx", "cy", "k": 3x1, "p": 2x1}, ...},
// millimetres. T is the camera's centre: x_cam = R (X - T). k: radial k1 k2 k3;
// p: tangential p1 p2.

bool RecogniseVoxelpose(const CalibrationHead& head) {
  return FirstMemberHas(head, {"T", "fx"}) && !FirstMemberHas(head, {"RT"});
}

CalibrationFile ReadVoxelpose(const CalibrationHead& head) {
  const JsonField root = head.Root();
  CalibrationFile file;
  file.unit = LengthUnit::kMillimetre;
  KeyReader(root).ReadUnit(&file);
  ReadMembers(root, &file, [](KeyReader* camera, CameraRecord* record) {
    record->K =
        CameraMatrix({camera->At("fx").Number(), camera->At("fy").Number(),
                      camera->At("cx").Number(), camera->At("cy").Number()});
    record->R = camera->Matrix3("R");
    record->centre = camera->Vector3("T");
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
  WriteTextFile(path, JsonLines(json));
}

// ---- longcw ----
// JSON of longcw's crossview data: {"cameras": {"Camera0": {"K": 3x3, "Tw":
// 4x4, "dist_coeffs": [k1, k2, p1, p2(, k3)]}, ...}}. K refers to coordinates
// divided by the image's width and height; Tw is world_from_cam, centimetres.

bool RecogniseLongcw(const CalibrationHead& head) {
  return HasOthersCameras(head) && FirstMemberHas(head.json["cameras"], {"Tw"});
}

CalibrationFile ReadLongcw(const CalibrationHead& head) {
  CalibrationFile file;
  file.unit = LengthUnit::kCentimetre;
  KeyReader keys(head.Root());
  keys.ReadUnit(&file);
  ReadMembers(
      keys.At("cameras"), &file, [](KeyReader* camera, CameraRecord* record) {
        record->K = camera->Matrix3("K");
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

// K is divided by the image size, which the file does not contain. Readers
// therefore require the size as an option, the same for all cameras.
void WriteLongcw(const std::string& path, const CameraRig& cameras,
                 LostFields* lost_fields) {
  Json members = Json::object();
  for (const Camera& camera : cameras) {
    if (!HasSize(camera)) {
      throw CannotWrite(camera,
                        "longcw's K is divided by the image size, which the "
                        "input does not specify (--image_size=W,H)");
    }
    if (camera.width_px() != cameras[0].width_px() ||
        camera.height_px() != cameras[0].height_px()) {
      throw CannotWrite(camera,
                        "has another image size than the first camera, which "
                        "longcw's format cannot express");
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
        {"dist_coeffs", RowMajor(OpenCvCoefficients(camera))}};
  }
  if (!cameras.empty()) {
    lost_fields->push_back(
        "the image size is not kept: specify it when reading "
        "(--image_size=" +
        std::to_string(cameras[0].width_px()) + "," +
        std::to_string(cameras[0].height_px()) + ")");
  }
  WriteTextFile(path, JsonLines(Json{{"cameras", members}}));
}

// ---- CMU Panoptic ----
// {"cameras": [{"name": "00_03", "resolution": [w, h], "K": 3x3, "distCoef":
// [k1, k2, p1, p2, k3], "R": 3x3, "t": 3x1}, ...]}: x_cam = R X + t,
// centimetres.

bool RecognisePanoptic(const CalibrationHead& head) {
  // AcinoSet's files, which an adapter reads, have one resolution for all
  // cameras.
  return HasOthersCameras(head) && head.json["cameras"].is_array() &&
         !head.HasJsonKey("camera_resolution");
}

CalibrationFile ReadPanoptic(const CalibrationHead& head) {
  CalibrationFile file;
  file.unit = LengthUnit::kCentimetre;
  KeyReader keys(head.Root());
  keys.ReadUnit(&file);
  for (const JsonField& element : keys.At("cameras").Elements("camera")) {
    file.cameras.push_back(
        ReadNamed(element, element.At("name").Text(),
                  [](KeyReader* camera, CameraRecord* record) {
                    camera->ReadImageSize("resolution", record);
                    record->K = camera->Matrix3("K");
                    camera->ReadLens(record);
                    record->R = camera->Matrix3("R");
                    record->t = camera->Vector3("t");
                  }));
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
    entry["distCoef"] = RowMajor(OpenCvCoefficients(camera));
    entry["R"] = JsonRows(camera.R());
    entry["t"] = JsonRows(t_cm);
    list.push_back(entry);
  }
  WriteTextFile(path, JsonLines(Json{{"cameras", list}}));
}

}  // namespace kinegraph
