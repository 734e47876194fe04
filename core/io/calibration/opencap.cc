// OpenCap's cameraIntrinsicsExtrinsics.pickle, one a camera in
// Videos/CAMERA of a session's folder: a dictionary of NumPy arrays
// intrinsicMat (3x3 px), distortion (OpenCV's five), imageSize (height, width),
// rotation (3x3) and translation (mm), x_cam = R X + t. The world is that of
// the calibration board. The camera's name is that of its folder.
#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/keys.h"
#include "core/io/files/text_file.h"
#include "core/io/text/names.h"
#include "core/io/text/pickle.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPickle = "cameraIntrinsicsExtrinsics.pickle";

// The pickles of a session: of the folders of cameras in `path` or in its
// folder Videos, or the one in `path` itself.
std::vector<std::string> FindPickles(const std::string& path) {
  const fs::path folder = path;
  if (IsFile((folder / kPickle).string())) return {(folder / kPickle).string()};
  for (const fs::path& parent : {folder / "Videos", folder}) {
    if (!IsFolder(parent.string())) continue;
    std::vector<std::string> cameras = ListFolder(parent.string());
    std::sort(cameras.begin(), cameras.end(), NaturalLess);
    std::vector<std::string> files;
    for (const std::string& camera : cameras) {
      const fs::path file = parent / camera / kPickle;
      if (IsFile(file.string())) files.push_back(file.string());
    }
    if (!files.empty()) return files;
  }
  return {};
}

bool RecogniseOpencap(const CalibrationHead& head) {
  if (head.is_folder) return !FindPickles(head.path).empty();
  return head.Is(CalibrationSyntax::kPickle);
}

std::string NameOf(const std::string& file) {
  std::error_code error;
  const fs::path path = fs::absolute(file, error);
  const std::string folder = path.parent_path().filename().string();
  return path.filename() == kPickle && !folder.empty() ? folder
                                                       : path.stem().string();
}

CameraRecord ReadOpencapCamera(const std::string& file) {
  constexpr size_t kMaxBytes = size_t{1} << 20;
  const Json json = ParsePickle(ReadBytes(file, kMaxBytes), file);
  CameraRecord record;
  record.file = file;
  record.name = NameOf(file);
  KeyReader camera(JsonField(json, file));
  record.K = ToMatrix3(camera.At("intrinsicMat").Matrix(3, 3));
  camera.ReadLens(&record);
  const std::vector<double> size = camera.At("imageSize").Matrix(2, 1);
  record.height_px = static_cast<int64_t>(std::clamp(size[0], 0.0, 1e9));
  record.width_px = static_cast<int64_t>(std::clamp(size[1], 0.0, 1e9));
  if (!camera.Find("rotation").has_value()) {
    camera.object().Fail(std::string("has no rotation: cameraIntrinsics.pickle "
                                     "has the lens alone, expected ") +
                         kPickle);
  }
  record.R = ToMatrix3(camera.At("rotation").Matrix(3, 3));
  record.t = ToVector3(camera.At("translation").Matrix(3, 1));
  camera.Find("rotation_EulerAngles");
  camera.RejectUnread();
  return record;
}

CalibrationFile ReadOpencap(const CalibrationHead& head) {
  CalibrationFile file;
  file.unit = LengthUnit::kMillimetre;
  const std::vector<std::string> files =
      head.is_folder ? FindPickles(head.path)
                     : std::vector<std::string>{head.path};
  for (const std::string& path : files)
    file.cameras.push_back(ReadOpencapCamera(path));
  return file;
}

}  // namespace

CalibrationFormat OpencapCalibrationFormat() {
  CalibrationFormat format;
  format.name = "opencap";
  format.layout =
      "a session's folder, cameraIntrinsicsExtrinsics.pickle a camera";
  format.syntax = CalibrationSyntax::kPickle;
  format.recognise = RecogniseOpencap;
  format.read = ReadOpencap;
  return format;
}

}  // namespace kinegraph
