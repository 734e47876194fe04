// OpenCV's YAML, a file a camera: camera_matrix, distortion_coefficients,
// image_width, image_height as OpenCV's calibration program and ROS write them.
// Neither writes a pose; it is read from rvec (or R, vector or matrix) and tvec
// (or T): x_cam = R X + T, metres. The camera's name is camera_name or the
// file's.
#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/keys.h"
#include "core/io/calibration/write_formats.h"
#include "core/io/calibration/yaml.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

bool RecogniseOpencv(const CalibrationHead& head) {
  if (head.is_folder) {
    return !YamlFilesAmong(head.names).empty() && !head.HasFile("intri.yml") &&
           !head.HasFile("intri.yaml") && !HasTumFiles(head.names);
  }
  return head.Is(CalibrationSyntax::kYaml) &&
         head.json.contains("camera_matrix") && !head.json.contains("names");
}

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
  const Json json = ReadCalibrationYaml(path.string());
  KeyReader root(JsonField(json, path.string()));
  CameraRecord record;
  record.file = path.string();
  const auto name = root.Find("camera_name");
  record.name = name.has_value() ? YamlNameOf(*name) : path.stem().string();
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

CalibrationFile ReadOpencv(const CalibrationHead& head) {
  CalibrationFile file;
  if (!head.is_folder) {
    file.cameras.push_back(ReadOpencvCamera(head.path));
    return file;
  }
  for (const std::string& name : YamlFilesAmong(head.names)) {
    file.cameras.push_back(ReadOpencvCamera(fs::path(head.path) / name));
  }
  if (file.cameras.empty())
    throw InputError(head.path, "", "has no YAML files");
  return file;
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
  if (IsFisheye(camera)) {
    // As OpenCV's calibration program marks it.
    text += "fisheye_model: 1\n";
    text += OpencvMatrix("distortion_coefficients",
                         FisheyeCoefficients(camera).transpose());
  } else {
    text += OpencvMatrix("distortion_coefficients",
                         OpenCvCoefficients(camera).transpose());
  }
  text += OpencvMatrix("R", camera.R());
  return text + OpencvMatrix("T", camera.t());
}

void WriteOpencv(const std::string& path, const CameraRig& cameras,
                 LostFields* lost_fields) {
  NoteUnknownSizes(cameras, lost_fields);
  AtomicFolder folder(path);
  for (const Camera& camera : cameras) {
    CheckKeyName(camera);
    WriteCalibrationYaml(folder.PathOf(camera.name() + ".yml"),
                         OpencvCameraText(camera));
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

}  // namespace

CalibrationFormat OpencvCalibrationFormat() {
  CalibrationFormat format;
  format.name = "opencv";
  format.layout = "YAML, a file a camera";
  format.syntax = CalibrationSyntax::kYaml;
  format.recognise = RecogniseOpencv;
  format.read = ReadOpencv;
  format.write = WriteOpencv;
  format.written_as = "folder, a file a camera";
  format.kept = "everything, bit for bit";
  format.lost =
      "lost: the order, which is that of the names; refused: names other than "
      "letters, digits, `_`, `-`";
  return format;
}

}  // namespace kinegraph
