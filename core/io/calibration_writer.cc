#include "core/io/calibration_writer.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "core/io/atomic_file.h"
#include "core/io/calibration_write_formats.h"

namespace kinegraph {
namespace {

using Format = CalibrationFormat;

void WriteText(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
}

// Formats that simply leave an unknown size out.
void NoteUnknownSizes(const CameraRig& cameras, Losses* losses) {
  if (!std::all_of(cameras.begin(), cameras.end(), HasSize)) {
    losses->push_back(
        "image sizes that the input does not tell are left out; other "
        "programs may need them (--image_size=W,H)");
  }
}

}  // namespace

const std::vector<CalibrationFormat>& WritableCalibrationFormats() {
  static const std::vector<Format> kFormats = {
      Format::kKinegraph, Format::kKrt,      Format::kVoxelpose,
      Format::kLongcw,    Format::kPanoptic, Format::kPose2sim,
      Format::kTum,       Format::kOpencv,   Format::kEasymocap};
  return kFormats;
}

void WriteCalibration(const std::string& path, CalibrationFormat format,
                      const CameraRig& cameras, Losses* losses) {
  switch (format) {
    case Format::kKinegraph:
      return WriteCameras(path, cameras);
    case Format::kVoxelpose:
      return WriteText(path, VoxelposeCamerasText(cameras, losses));
    case Format::kLongcw:
      return WriteText(path, LongcwCamerasText(cameras, losses));
    case Format::kOpencv:
      NoteUnknownSizes(cameras, losses);
      return WriteOpencvCameras(path, cameras, losses);
    case Format::kTum:
      return WriteTumCameras(path, cameras, losses);
    case Format::kKrt:
      NoteUnknownSizes(cameras, losses);
      return WriteText(path, KrtCamerasText(cameras));
    case Format::kPanoptic:
      NoteUnknownSizes(cameras, losses);
      return WriteText(path, PanopticCamerasText(cameras));
    case Format::kPose2sim:
      NoteUnknownSizes(cameras, losses);
      return WriteText(path, Pose2simCamerasText(cameras));
    case Format::kEasymocap:
      NoteUnknownSizes(cameras, losses);
      return WriteEasymocapCameras(path, cameras);
    default:
      throw std::logic_error("this calibration format is not written");
  }
}

InputError CannotWrite(const Camera& camera, const std::string& message) {
  return InputError("camera '" + Printable(camera.name()) + "': " + message);
}

Eigen::Matrix<double, 5, 1> OpenCvCoefficients(const Camera& camera) {
  Eigen::Matrix<double, 5, 1> coefficients =
      Eigen::Matrix<double, 5, 1>::Zero();
  if (camera.lens() == nullptr) return coefficients;
  const std::vector<double> parameters = camera.lens()->parameters();
  if (camera.lens()->model() != "opencv5" || parameters.size() != 5) {
    throw CannotWrite(camera, "the lens model '" + camera.lens()->model() +
                                  "' cannot be said in this format");
  }
  std::copy(parameters.begin(), parameters.end(), coefficients.data());
  return coefficients;
}

std::string JsonLines(const Json& object) {
  return object.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string DecimalText(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

Eigen::Vector3d RotationVector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd rotation(R);
  return rotation.angle() * rotation.axis();
}

}  // namespace kinegraph
