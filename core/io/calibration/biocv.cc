// bioCV's .calib, a file a camera: numbers separated by spaces and line ends,
// the image's width and height, K (3x3 px, by rows), the pose (4x4 by rows:
// x_cam = R X + t, mm) and OpenCV's k1 k2 p1 p2 k3. "00.mp4.calib" is the
// camera "00".
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/base/error.h"
#include "core/io/calibration/format.h"
#include "core/io/text/names.h"
#include "core/io/text/words.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".calib";

bool IsCalib(const std::string& name) {
  return fs::path(name).extension() == kExtension;
}

bool RecogniseBiocv(const CalibrationHead& head) {
  if (head.is_folder) {
    return std::any_of(head.names.begin(), head.names.end(), IsCalib) &&
           !HasTumFiles(head.names);
  }
  return IsCalib(head.path) && (head.Is(CalibrationSyntax::kNumbers) ||
                                head.Is(CalibrationSyntax::kOther));
}

CameraRecord ReadBiocvCamera(const std::string& path) {
  const std::vector<double> numbers = ReadNumberTable(
      path, 2 + 9 + 16 + 5,
      "32: width, height, K, the pose (4x4) and k1 k2 p1 p2 k3");
  CameraRecord record;
  record.file = path;
  record.name = fs::path(path).stem().stem().string();
  for (const double side : {numbers[0], numbers[1]}) {
    if (side >= 0.0 && side <= 1e6 && side == std::floor(side)) continue;
    throw InputError(path, "", "expected a width and a height in px");
  }
  record.width_px = static_cast<int64_t>(numbers[0]);
  record.height_px = static_cast<int64_t>(numbers[1]);
  const double* K = &numbers[2];
  record.K = ToMatrix3({K, K + 9});
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> pose(
      &numbers[11]);
  if (pose.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)) {
    throw InputError(path, "", "the pose's last row is not 0 0 0 1");
  }
  record.R = pose.topLeftCorner<3, 3>();
  record.t = pose.topRightCorner<3, 1>();
  record.distortion.assign(numbers.end() - 5, numbers.end());
  return record;
}

CalibrationFile ReadBiocv(const CalibrationHead& head) {
  CalibrationFile file;
  file.unit = LengthUnit::kMillimetre;
  if (!head.is_folder) {
    file.cameras.push_back(ReadBiocvCamera(head.path));
    return file;
  }
  std::vector<std::string> names = head.names;
  std::sort(names.begin(), names.end(), NaturalLess);
  for (const std::string& name : names) {
    if (!IsCalib(name)) continue;
    file.cameras.push_back(
        ReadBiocvCamera((fs::path(head.path) / name).string()));
  }
  return file;
}

}  // namespace

CalibrationFormat BiocvCalibrationFormat() {
  CalibrationFormat format;
  format.name = "biocv";
  format.layout = "bioCV's .calib, a file a camera";
  format.syntax = CalibrationSyntax::kNumbers;
  format.recognise = RecogniseBiocv;
  format.read = ReadBiocv;
  return format;
}

}  // namespace kinegraph
