// EasyMocap: intri.yml with `names` and, a camera, K_NAME (3x3 px), dist_NAME
// or D_NAME (k1 k2 p1 p2 k3) and perhaps W_NAME, H_NAME; extri.yml with R_NAME
// (Rodrigues vector) or Rot_NAME (3x3) and T_NAME: x_cam = R X + T, metres.
// Read from the folder of both, from one of the two, or from one file with the
// content of both.
#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/base/split.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/keys.h"
#include "core/io/calibration/write_formats.h"
#include "core/io/calibration/yaml.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

bool RecogniseEasymocap(const CalibrationHead& head) {
  if (head.is_folder) {
    return (head.HasFile("intri.yml") || head.HasFile("intri.yaml")) &&
           !HasTumFiles(head.names);
  }
  return head.Is(CalibrationSyntax::kYaml) && head.json.contains("names");
}

struct EasymocapFiles {
  fs::path intrinsic;
  fs::path extrinsic;
};

EasymocapFiles FindEasymocapFiles(const fs::path& path) {
  const bool folder = IsFolder(path.string());
  for (const char* extension : {".yml", ".yaml"}) {
    const std::string intri = std::string("intri") + extension;
    const std::string extri = std::string("extri") + extension;
    const std::string name = path.filename().string();
    if (!folder && name != intri && name != extri) continue;
    const fs::path parent = folder ? path : path.parent_path();
    if (!folder || IsFile((parent / intri).string())) {
      return {parent / intri, parent / extri};
    }
  }
  if (folder) {
    throw InputError(path.string(), "", "has no intri.yml");
  }
  return {path, path};  // one file with the content of both
}

Eigen::Matrix3d ReadEasymocapRotation(const JsonField& extrinsic,
                                      const std::string& name) {
  const auto vector = extrinsic.Find("R_" + name);
  const auto matrix = extrinsic.Find("Rot_" + name);
  if (!vector.has_value()) {
    return ToMatrix3(
        KeyReader(extrinsic).AtAny({"R_" + name, "Rot_" + name}).Matrix(3, 3));
  }
  const Eigen::Matrix3d R = ReadRotation(*vector);
  if (matrix.has_value() &&
      (R - ToMatrix3(matrix->Matrix(3, 3))).cwiseAbs().maxCoeff() >
          kPoseRounding) {
    matrix->Fail("is not the rotation of R_" + name);
  }
  return R;
}

// The members "KEY_NAME" of one camera as an object with the members "KEY".
Json MembersOf(const Json& root, const std::string& name) {
  Json camera = Json::object();
  for (const auto& [key, value] : root.items()) {
    if (!EndsIn(key, "_" + name)) continue;
    camera[key.substr(0, key.size() - name.size() - 1)] = value;
  }
  return camera;
}

// EasyMocap takes the cameras that `names` lists; what the file says of others
// is passed over with them.
void RejectUnreadMembers(const JsonField& root,
                         const std::vector<std::string>& names) {
  static const std::vector<std::string> kOfCameras = {
      "K_", "dist_", "D_", "R_", "Rot_", "T_", "W_", "H_"};
  for (const auto& [key, value] : root.value().items()) {
    const std::string& member = key;
    const bool of_camera = std::any_of(names.begin(), names.end(),
                                       [&](const std::string& name) {
                                         return EndsIn(member, "_" + name);
                                       }) ||
                           std::any_of(kOfCameras.begin(), kOfCameras.end(),
                                       [&](const std::string& beginning) {
                                         return member.rfind(beginning, 0) == 0;
                                       });
    if (of_camera || member == "names" || IsHarmlessKey(member)) continue;
    root.Fail("has a key '" + Printable(member) +
              "' that is not known in this format: it could carry lens or "
              "pose, so it is not passed over");
  }
}

CameraRecord ReadEasymocapCamera(const JsonField& intrinsic_file,
                                 const JsonField& extrinsic_file,
                                 const std::string& name) {
  const std::string where = "camera '" + Printable(name) + "'";
  const Json intrinsic_json = MembersOf(intrinsic_file.value(), name);
  const Json extrinsic_json = MembersOf(extrinsic_file.value(), name);
  KeyReader intrinsic(JsonField(intrinsic_json, intrinsic_file.file(), where));
  KeyReader extrinsic(JsonField(extrinsic_json, extrinsic_file.file(), where));
  CameraRecord record;
  record.name = name;
  record.K = ToMatrix3(intrinsic_file.At("K_" + name).Matrix(3, 3));
  intrinsic.Find("K");
  intrinsic.ReadLens(&record);
  const auto width = intrinsic.Find("W");
  const auto height = intrinsic.Find("H");
  if (width.has_value() && height.has_value()) {
    record.width_px = width->Integer();
    record.height_px = height->Integer();
  }
  record.R = ReadEasymocapRotation(extrinsic_file, name);
  record.t = ToVector3(extrinsic_file.At("T_" + name).Matrix(3, 1));
  for (const char* key : {"R", "Rot", "T"}) {
    extrinsic.Find(key);
    intrinsic.Find(key);  // one file may hold both
  }
  intrinsic.RejectUnread();
  if (intrinsic_file.file() != extrinsic_file.file()) extrinsic.RejectUnread();
  return record;
}

CalibrationFile ReadEasymocap(const CalibrationHead& head) {
  const std::string& path = head.path;
  const EasymocapFiles files = FindEasymocapFiles(path);
  const Json intrinsic_json = ReadCalibrationYaml(files.intrinsic.string());
  const bool one_file = files.intrinsic == files.extrinsic;
  const Json extrinsic_json =
      one_file ? intrinsic_json : ReadCalibrationYaml(files.extrinsic.string());
  const JsonField intrinsic(intrinsic_json, files.intrinsic.string());
  const JsonField extrinsic(extrinsic_json, files.extrinsic.string());
  CalibrationFile file;
  std::vector<std::string> names;
  for (const JsonField& element : intrinsic.At("names").Elements("name")) {
    names.push_back(YamlNameOf(element));
    CameraRecord record =
        ReadEasymocapCamera(intrinsic, extrinsic, names.back());
    record.file = path;
    file.cameras.push_back(record);
  }
  RejectUnreadMembers(intrinsic, names);
  RejectUnreadMembers(extrinsic, names);
  return file;
}

void WriteEasymocap(const std::string& path, const CameraRig& cameras,
                    LostFields* lost_fields) {
  NoteUnknownSizes(cameras, lost_fields);
  std::string names;
  std::string intrinsic;
  std::string extrinsic;
  for (const Camera& camera : cameras) {
    CheckKeyName(camera);
    const std::string& name = camera.name();
    names += "  - \"" + name + "\"\n";
    intrinsic += OpencvMatrix("K_" + name, camera.K());
    intrinsic +=
        OpencvMatrix("dist_" + name, OpenCvCoefficients(camera).transpose());
    if (HasSize(camera)) {
      intrinsic += "H_" + name + ": " + std::to_string(camera.height_px()) +
                   "\nW_" + name + ": " + std::to_string(camera.width_px()) +
                   "\n";
    }
    extrinsic += OpencvMatrix("R_" + name, RotationVector(camera.R()));
    extrinsic += OpencvMatrix("Rot_" + name, camera.R());
    extrinsic += OpencvMatrix("T_" + name, camera.t());
  }
  AtomicFolder folder(path);
  WriteCalibrationYaml(folder.PathOf("intri.yml"),
                       "names:\n" + names + intrinsic);
  WriteCalibrationYaml(folder.PathOf("extri.yml"),
                       "names:\n" + names + extrinsic);
  folder.Commit();
}

}  // namespace

CalibrationFormat EasymocapCalibrationFormat() {
  CalibrationFormat format;
  format.name = "easymocap";
  format.layout = "intri.yml and extri.yml";
  format.syntax = CalibrationSyntax::kYaml;
  format.recognise = RecogniseEasymocap;
  format.read = ReadEasymocap;
  format.write = WriteEasymocap;
  format.written_as = "folder";
  format.kept = "everything; R as a rotation vector, to 1e-14";
  format.lost = "refused: names as for `opencv`";
  return format;
}

}  // namespace kinegraph
