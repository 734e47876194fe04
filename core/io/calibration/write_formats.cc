#include "core/io/calibration/write_formats.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/data/checks.h"
#include "core/io/calibration/format.h"

namespace kinegraph {

void WriteCalibration(const std::string& path, const std::string& format,
                      const CameraRig& cameras, LostFields* lost_fields) {
  const CalibrationFormat* found = FindCalibrationFormat(format);
  if (found == nullptr || found->write == nullptr) {
    std::string names;
    for (const CalibrationFormat& one : CalibrationFormats()) {
      if (one.write == nullptr) continue;
      names += (names.empty() ? "" : ", ") + one.name;
    }
    throw InputError("format: found '" + Printable(format) +
                     "', expected one of " + names);
  }
  CheckCameraNames(cameras);
  found->write(path, cameras, lost_fields);
}

void NoteUnknownSizes(const CameraRig& cameras, LostFields* lost_fields) {
  if (std::all_of(cameras.begin(), cameras.end(), HasSize)) return;
  lost_fields->push_back(
      "image sizes that the input does not specify are omitted; other programs "
      "may need them (--image_size=W,H)");
}

void CheckSkew(const Camera& camera) {
  // Cameras from rounded projection matrices have a small skew (0.005 px on
  // Shelf). It displaces a pixel by skew * y / z, which is at most the skew
  // itself within a field of view of 90 degrees: far below the accuracy of a
  // calibration.
  constexpr double kRoundingPx = 0.01;
  if (std::abs(camera.K()(0, 1)) > kRoundingPx) {
    throw CannotWrite(camera, "a skewed K cannot be expressed in this format");
  }
}

void NoteSkew(const CameraRig& cameras, LostFields* lost_fields) {
  double largest_px = 0.0;
  for (const Camera& camera : cameras) {
    largest_px = std::max(largest_px, std::abs(camera.K()(0, 1)));
  }
  if (largest_px == 0.0) return;
  lost_fields->push_back("a skew of up to " + std::to_string(largest_px) +
                         " px is omitted");
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
    throw CannotWrite(camera,
                      "the lens model '" + camera.lens()->model() +
                          "' cannot be expressed in this format; the formats "
                          "kinegraph, pose2sim, opencv and colmap allow it");
  }
  std::copy(parameters.begin(), parameters.end(), coefficients.data());
  return coefficients;
}

bool IsFisheye(const Camera& camera) {
  return camera.lens() != nullptr && camera.lens()->model() == kFisheyeModel;
}

Eigen::RowVectorXd LensTerms(const Camera& camera) {
  if (!IsFisheye(camera)) return OpenCvCoefficients(camera).transpose();
  return Eigen::RowVector4d(camera.lens()->parameters().data());
}

std::string JsonLines(const Json& object) { return DumpJson(object, 1) + "\n"; }

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
