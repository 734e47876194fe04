// Calibrations in YAML: OpenCV's and EasyMocap's.
#include <algorithm>
#include <filesystem>
#include <iterator>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/write_formats.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHead = "%YAML:1.0\n---\n";

// Largest difference between elements of two representations of the same matrix
// or vector (R_NAME and Rot_NAME, rvec and R): well above the rounding of files
// with six decimals.
constexpr double kPoseRounding = 1e-3;

std::vector<std::string> YamlFilesAmong(const std::vector<std::string>& names) {
  std::vector<std::string> files;
  std::copy_if(names.begin(), names.end(), std::back_inserter(files),
               IsYamlName);
  return files;
}

// A name; one without quotes may have been read as a number.
std::string YamlNameOf(const JsonField& field) {
  if (field.value().is_number()) return std::to_string(field.Integer());
  return field.Text();
}

// Throws InputError naming a camera whose name cannot be part of a key of
// OpenCV's FileStorage, as in EasyMocap's files. Such a name is refused for
// OpenCV's files too, which are named after their cameras.
void CheckKeyName(const Camera& camera) {
  const bool is_plain =
      std::all_of(camera.name().begin(), camera.name().end(), [](const char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
               (c >= 'A' && c <= 'Z') || c == '_' || c == '-';
      });
  if (is_plain) return;
  throw CannotWrite(camera,
                    "the name cannot be part of a key of OpenCV's YAML, "
                    "expected letters, digits, '_' and '-'");
}

template <typename Matrix>
std::string OpencvMatrix(const std::string& key, const Matrix& matrix) {
  return key + ": !!opencv-matrix\n  rows: " + std::to_string(matrix.rows()) +
         "\n  cols: " + std::to_string(matrix.cols()) +
         "\n  dt: d\n  data: " + DecimalList(matrix) + "\n";
}

// ---- OpenCV ----
// OpenCV's YAML, one file per camera: camera_matrix, distortion_coefficients,
// image_width, image_height as OpenCV's calibration program and ROS write them.
// Neither writes a pose; it is read from rvec (or R, vector or matrix) and tvec
// (or T): x_cam = R X + T, metres. The camera's name is camera_name, otherwise
// the file name without extension.

// The first of two spellings; if both are present they must agree.
template <typename Read>
auto ReadEither(KeyReader* camera, const char* first, const char* second,
                const Read& read) {
  auto value = read(camera->AtAny({first, second}));
  const auto other = camera->Find(second);
  if (other.has_value() &&
      (read(*other) - value).cwiseAbs().maxCoeff() > kPoseRounding) {
    other->Fail(std::string("contradicts ") + first);
  }
  return value;
}

CameraRecord ReadOpencvCamera(const std::string& path) {
  const Json json = ReadCalibrationYaml(path);
  KeyReader root(JsonField(json, path));
  CameraRecord record;
  record.file = path;
  const auto name = root.Find("camera_name");
  record.name =
      name.has_value() ? YamlNameOf(*name) : fs::path(path).stem().string();
  const auto read_intrinsics = [](const JsonField& field) -> Eigen::Matrix3d {
    return ToMatrix3(field.Matrix(3, 3));
  };
  record.K = ReadEither(&root, "camera_matrix", "K", read_intrinsics);
  root.ReadLens(&record);
  root.ReadImageSize("image_width", "image_height", &record);
  record.R = ReadEither(&root, "rvec", "R", ReadRotation);
  const auto read_t = [](const JsonField& field) -> Eigen::Vector3d {
    return ToVector3(field.Matrix(3, 1));
  };
  record.t = ReadEither(&root, "tvec", "T", read_t);
  root.RejectUnread();
  return record;
}

// The keys of OpenCV's and ROS's calibration programs, with R and T for the
// pose as in OpenCV's stereo calibration.
std::string OpencvCameraText(const Camera& camera) {
  std::string text;
  if (HasSize(camera)) {
    text += "image_width: " + std::to_string(camera.width_px()) +
            "\nimage_height: " + std::to_string(camera.height_px()) + "\n";
  }
  text += "camera_name: \"" + camera.name() + "\"\n";
  text += OpencvMatrix("camera_matrix", camera.K());
  // The flag of OpenCV's calibration program.
  if (IsFisheye(camera)) text += "fisheye_model: 1\n";
  text += OpencvMatrix("distortion_coefficients", LensTerms(camera));
  text += OpencvMatrix("R", camera.R());
  return text + OpencvMatrix("T", camera.t());
}

}  // namespace

bool RecogniseOpencv(const CalibrationHead& head) {
  if (head.is_folder) {
    return !YamlFilesAmong(head.names).empty() && !head.HasFile("intri.yml") &&
           !head.HasFile("intri.yaml") && !HasTumFiles(head.names);
  }
  return head.Is(CalibrationSyntax::kYaml) &&
         head.json.contains("camera_matrix") && !head.json.contains("names");
}

CalibrationFile ReadOpencv(const CalibrationHead& head) {
  const std::vector<std::string> files = YamlFilesAmong(head.names);
  if (head.is_folder && files.empty()) {
    throw InputError(head.path, "", "has no YAML files");
  }
  return ReadFileACamera(head, files, LengthUnit::kMetre, ReadOpencvCamera);
}

void WriteOpencv(const std::string& path, const CameraRig& cameras,
                 LostFields* lost_fields) {
  NoteUnknownSizes(cameras, lost_fields);
  AtomicFolder folder(path);
  for (const Camera& camera : cameras) {
    CheckKeyName(camera);
    WriteTextFile(folder.PathOf(camera.name() + ".yml"),
                  kHead + OpencvCameraText(camera));
  }
  folder.Commit();
  const bool sorted = std::is_sorted(
      cameras.begin(), cameras.end(), [](const Camera& a, const Camera& b) {
        return a.name() + ".yml" < b.name() + ".yml";
      });
  if (!sorted) {
    lost_fields->push_back("cameras are read back in the order of their names");
  }
}

// ---- EasyMocap ----
// EasyMocap: intri.yml with `names` and, per camera, K_NAME (3x3 px), dist_NAME
// or D_NAME (k1 k2 p1 p2 k3) and optionally W_NAME, H_NAME; extri.yml with
// R_NAME (Rodrigues vector) or Rot_NAME (3x3) and T_NAME: x_cam = R X + T,
// metres. The path may be the folder of both files, either of them, or one file
// with the content of both.

namespace {

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
    throw InputError(path.string(), "", "has no intri.yml or intri.yaml");
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
  Eigen::Matrix3d R = ReadRotation(*vector);
  if (matrix.has_value() &&
      (R - ToMatrix3(matrix->Matrix(3, 3))).cwiseAbs().maxCoeff() >
          kPoseRounding) {
    matrix->Fail("is not the rotation of R_" + name);
  }
  return R;
}

// The members "KEY_NAME" of one camera as an object with the members "KEY".
// "K_front_left" belongs to the camera front_left of `names`, not to left.
Json MembersOf(const Json& root, const std::string& name,
               const std::vector<std::string>& names) {
  Json camera = Json::object();
  for (const auto& [key, value] : root.items()) {
    const std::string& member = key;
    const auto is_of_longer = [&](const std::string& other) {
      return other.size() > name.size() && EndsIn(member, "_" + other);
    };
    if (!EndsIn(key, "_" + name) ||
        std::any_of(names.begin(), names.end(), is_of_longer)) {
      continue;
    }
    camera[key.substr(0, key.size() - name.size() - 1)] = value;
  }
  return camera;
}

// Throws InputError for an unknown key. Members of cameras that `names` does
// not list are ignored, as by EasyMocap.
void RejectUnreadMembers(const JsonField& root,
                         const std::vector<std::string>& names) {
  static const std::vector<std::string> kOfCameras = {
      "K_", "dist_", "D_", "R_", "Rot_", "T_", "W_", "H_"};
  for (const auto& [key, value] : root.value().items()) {
    const std::string& member = key;
    const auto is_of = [&](const std::string& name) {
      return EndsIn(member, "_" + name);
    };
    const auto begins_with = [&](const std::string& beginning) {
      return member.rfind(beginning, 0) == 0;
    };
    if (member == "names" || IsHarmlessKey(member) ||
        std::any_of(names.begin(), names.end(), is_of) ||
        std::any_of(kOfCameras.begin(), kOfCameras.end(), begins_with)) {
      continue;
    }
    FailUnread(root, member);
  }
}

CameraRecord ReadEasymocapCamera(const JsonField& intrinsic_file,
                                 const JsonField& extrinsic_file,
                                 const std::string& name,
                                 const std::vector<std::string>& names) {
  const std::string where = "camera '" + Printable(name) + "'";
  const Json intrinsic_json = MembersOf(intrinsic_file.value(), name, names);
  const Json extrinsic_json = MembersOf(extrinsic_file.value(), name, names);
  KeyReader intrinsic(JsonField(intrinsic_json, intrinsic_file.file(), where));
  KeyReader extrinsic(JsonField(extrinsic_json, extrinsic_file.file(), where));
  CameraRecord record;
  record.name = name;
  record.K = KeyReader(intrinsic_file).Matrix3("K_" + name);
  intrinsic.Find("K");
  intrinsic.ReadLens(&record);
  intrinsic.ReadImageSize("W", "H", &record);
  record.R = ReadEasymocapRotation(extrinsic_file, name);
  record.t = KeyReader(extrinsic_file).Vector3("T_" + name);
  for (const char* key : {"R", "Rot", "T"}) {
    extrinsic.Find(key);
    intrinsic.Find(key);  // one file may contain both
  }
  intrinsic.RejectUnread();
  if (intrinsic_file.file() != extrinsic_file.file()) extrinsic.RejectUnread();
  return record;
}

}  // namespace

bool RecogniseEasymocap(const CalibrationHead& head) {
  if (head.is_folder) {
    return (head.HasFile("intri.yml") || head.HasFile("intri.yaml")) &&
           !HasTumFiles(head.names);
  }
  return head.Is(CalibrationSyntax::kYaml) && head.json.contains("names");
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
  }
  for (const std::string& name : names) {
    CameraRecord record =
        ReadEasymocapCamera(intrinsic, extrinsic, name, names);
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
  WriteTextFile(folder.PathOf("intri.yml"),
                kHead + ("names:\n" + names + intrinsic));
  WriteTextFile(folder.PathOf("extri.yml"),
                kHead + ("names:\n" + names + extrinsic));
  folder.Commit();
}

}  // namespace kinegraph
