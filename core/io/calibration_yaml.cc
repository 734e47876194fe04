// YAML calibrations.
//
// EasyMocap: intri.yml with `names` and, a camera, K_NAME (3x3 px), dist_NAME
// or D_NAME (k1 k2 p1 p2 k3) and perhaps W_NAME, H_NAME; extri.yml with R_NAME
// (Rodrigues vector) or Rot_NAME (3x3) and T_NAME: x_cam = R X + T, metres.
//
// OpenCV, a file a camera: camera_matrix, distortion_coefficients, image_width,
// image_height as OpenCV's calibration program and ROS write them. Neither
// writes a pose; it is read from rvec (or R, vector or matrix) and tvec (or T):
// x_cam = R X + T, metres. The camera's name is camera_name or the file's.
#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/io/atomic_file.h"
#include "core/io/atomic_folder.h"
#include "core/io/calibration_formats.h"
#include "core/io/calibration_keys.h"
#include "core/io/calibration_write_formats.h"
#include "core/io/text_file.h"
#include "core/io/yaml_file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

Json ReadYaml(const fs::path& path) {
  // Four thousand cameras; the parser is slow.
  constexpr size_t kMaxBytes = size_t{4} << 20;
  return ParseYaml(ReadTextFile(path.string(), kMaxBytes), path.string());
}

bool IsYamlName(const std::string& name) {
  const std::string extension = fs::path(name).extension().string();
  return extension == ".yml" || extension == ".yaml";
}

std::vector<std::string> ListYamlFiles(const std::string& folder) {
  std::vector<std::string> names = ListFolder(folder);
  names.erase(
      std::remove_if(names.begin(), names.end(),
                     [](const std::string& name) { return !IsYamlName(name); }),
      names.end());
  return names;
}

// A rotation as a Rodrigues vector or a matrix.
Eigen::Matrix3d ReadRotation(const JsonField& field) {
  const bool nested = field.value().is_array() && field.value().size() == 3 &&
                      field.value().front().is_array();
  if (nested && field.value().front().size() == 3) {
    return ToMatrix3(field.Matrix(3, 3));
  }
  return RotationOf(ToVector3(field.Matrix(3, 1)));
}

// ---- EasyMocap ----

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

// A name in `names`: a text, or a number without quotes.
std::string NameOf(const JsonField& field) {
  if (field.value().is_number()) return std::to_string(field.Integer());
  return field.Text();
}

// A pose that is written in two ways must be one pose. Files are written with
// six decimals; further apart they are two different ones.
constexpr double kPoseRounding = 1e-3;

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

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() > end.size() &&
         text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// The members "KEY_NAME" of one camera as an object with the members "KEY".
Json MembersOf(const Json& root, const std::string& name) {
  Json camera = Json::object();
  for (const auto& [key, value] : root.items()) {
    if (!EndsWith(key, "_" + name)) continue;
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
                                         return EndsWith(member, "_" + name);
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

}  // namespace

CalibrationFile ReadEasymocapCameras(const std::string& path) {
  const EasymocapFiles files = FindEasymocapFiles(path);
  const Json intrinsic_json = ReadYaml(files.intrinsic);
  const bool one_file = files.intrinsic == files.extrinsic;
  const Json extrinsic_json =
      one_file ? intrinsic_json : ReadYaml(files.extrinsic);
  const JsonField intrinsic(intrinsic_json, files.intrinsic.string());
  const JsonField extrinsic(extrinsic_json, files.extrinsic.string());
  CalibrationFile file;
  std::vector<std::string> names;
  for (const JsonField& element : intrinsic.At("names").Elements("name")) {
    names.push_back(NameOf(element));
    CameraRecord record =
        ReadEasymocapCamera(intrinsic, extrinsic, names.back());
    record.file = path;
    file.cameras.push_back(record);
  }
  RejectUnreadMembers(intrinsic, names);
  RejectUnreadMembers(extrinsic, names);
  return file;
}

namespace {

// ---- OpenCV ----

// The first of two spellings; where both are there they must agree.
template <typename Read>
auto ReadEither(KeyReader* camera, const char* first, const char* second,
                const Read& read) {
  const auto value = read(camera->AtAny({first, second}));
  const auto other = camera->Find(second);
  if (other.has_value() &&
      (read(*other) - value).cwiseAbs().maxCoeff() > kPoseRounding) {
    other->Fail(std::string("does not say the same as ") + first);
  }
  return value;
}

CameraRecord ReadOpencvCamera(const fs::path& path) {
  const Json json = ReadYaml(path);
  KeyReader root(JsonField(json, path.string()));
  CameraRecord record;
  record.file = path.string();
  const auto name = root.Find("camera_name");
  record.name = name.has_value() ? NameOf(*name) : path.stem().string();
  const auto read_K = [](const JsonField& field) -> Eigen::Matrix3d {
    return ToMatrix3(field.Matrix(3, 3));
  };
  record.K = ReadEither(&root, "camera_matrix", "K", read_K);
  root.ReadLens(&record);
  const auto width = root.Find("image_width");
  const auto height = root.Find("image_height");
  if (width.has_value() && height.has_value()) {
    record.width_px = width->Integer();
    record.height_px = height->Integer();
  }
  record.R = ReadEither(&root, "rvec", "R", ReadRotation);
  const auto read_t = [](const JsonField& field) -> Eigen::Vector3d {
    return ToVector3(field.Matrix(3, 1));
  };
  record.t = ReadEither(&root, "tvec", "T", read_t);
  root.RejectUnread();
  return record;
}

}  // namespace

CalibrationFile ReadOpencvCameras(const std::string& path) {
  CalibrationFile file;
  if (!IsFolder(path)) {
    file.cameras.push_back(ReadOpencvCamera(path));
    return file;
  }
  for (const std::string& name : ListYamlFiles(path)) {
    file.cameras.push_back(ReadOpencvCamera(fs::path(path) / name));
  }
  if (file.cameras.empty()) throw InputError(path, "", "has no YAML files");
  return file;
}

CalibrationFormat DetectYamlFormat(const std::string& path) {
  if (IsFolder(path)) {
    const std::vector<std::string> names = ListYamlFiles(path);
    for (const char* name : {"intri.yml", "intri.yaml"}) {
      if (std::binary_search(names.begin(), names.end(), name)) {
        return CalibrationFormat::kEasymocap;
      }
    }
    return names.empty() ? CalibrationFormat::kAuto
                         : CalibrationFormat::kOpencv;
  }
  const Json json = ReadYaml(path);
  if (json.contains("names")) return CalibrationFormat::kEasymocap;
  if (json.contains("camera_matrix")) return CalibrationFormat::kOpencv;
  return CalibrationFormat::kAuto;
}

// ---- Writing ----

namespace {

// OpenCV's FileStorage, which EasyMocap reads with, takes no other characters
// in a key.
void CheckKeyName(const Camera& camera) {
  for (const char c : camera.name()) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                       (c >= 'A' && c <= 'Z') || c == '_' || c == '-';
    if (!plain) {
      throw CannotWrite(camera,
                        "the name cannot stand in a key of OpenCV's YAML, "
                        "expected letters, digits, '_' and '-'");
    }
  }
}

template <typename Matrix>
std::string OpencvMatrix(const std::string& key, const Matrix& matrix) {
  return key + ": !!opencv-matrix\n  rows: " + std::to_string(matrix.rows()) +
         "\n  cols: " + std::to_string(matrix.cols()) +
         "\n  dt: d\n  data: " + DecimalList(matrix) + "\n";
}

void WriteYaml(const std::string& path, const std::string& content) {
  AtomicFile file(path);
  file.Write("%YAML:1.0\n---\n" + content);
  file.Commit();
}

// The keys of OpenCV's and ROS' calibration programs, with R and T as OpenCV's
// stereo calibration calls a pose.
std::string OpencvCameraText(const Camera& camera) {
  std::string text;
  if (HasSize(camera)) {
    text += "image_width: " + std::to_string(camera.width_px()) +
            "\nimage_height: " + std::to_string(camera.height_px()) + "\n";
  }
  text += "camera_name: \"" + camera.name() + "\"\n";
  text += OpencvMatrix("camera_matrix", camera.K());
  text += OpencvMatrix("distortion_coefficients",
                       OpenCvCoefficients(camera).transpose());
  text += OpencvMatrix("R", camera.R());
  return text + OpencvMatrix("T", camera.t());
}

}  // namespace

void WriteEasymocapCameras(const std::string& path, const CameraRig& cameras) {
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
  WriteYaml(folder.PathOf("intri.yml"), "names:\n" + names + intrinsic);
  WriteYaml(folder.PathOf("extri.yml"), "names:\n" + names + extrinsic);
  folder.Commit();
}

void WriteOpencvCameras(const std::string& path, const CameraRig& cameras,
                        Losses* losses) {
  AtomicFolder folder(path);
  for (const Camera& camera : cameras) {
    CheckKeyName(camera);
    WriteYaml(folder.PathOf(camera.name() + ".yml"), OpencvCameraText(camera));
  }
  folder.Commit();
  const bool sorted = std::is_sorted(
      cameras.begin(), cameras.end(), [](const Camera& a, const Camera& b) {
        return a.name() + ".yml" < b.name() + ".yml";
      });
  if (!sorted) {
    losses->push_back("cameras are read back in the order of their names");
  }
}

}  // namespace kinegraph
