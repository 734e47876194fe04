// Shared by the writers of calibration formats. For core/io only.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_WRITE_FORMATS_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_WRITE_FORMATS_H_

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/camera.h"
#include "core/io/text/json.h"
#include "core/io/text/lost_fields.h"

namespace kinegraph {

inline bool HasSize(const Camera& camera) {
  return camera.width_px() > 0 && camera.height_px() > 0;
}

// Notes unknown image sizes, for formats that omit them.
void NoteUnknownSizes(const CameraRig& cameras, LostFields* lost_fields);

// For formats without skew: CheckSkew throws InputError naming the camera if
// its skew exceeds 0.01 px (less may be rounding); NoteSkew notes the largest
// skew that is omitted.
void CheckSkew(const Camera& camera);
void NoteSkew(const CameraRig& cameras, LostFields* lost_fields);

// k1 k2 p1 p2 k3; zeros without a lens. Throws InputError naming the camera for
// lens models other than opencv5.
Eigen::Matrix<double, 5, 1> OpenCvCoefficients(const Camera& camera);

bool IsFisheye(const Camera& camera);
// k1 k2 k3 k4 of a fisheye lens, otherwise OpenCvCoefficients.
Eigen::RowVectorXd LensTerms(const Camera& camera);

// The error "camera 'NAME': message".
InputError CannotWrite(const Camera& camera, const std::string& message);

// JSON text with one value per line; replacement characters for names that are
// not UTF-8.
std::string JsonLines(const Json& object);

// All numbers of a matrix in one list, row by row.
template <typename Matrix>
std::vector<double> RowMajor(const Matrix& matrix) {
  const auto numbers = matrix.template reshaped<Eigen::RowMajor>();
  return {numbers.begin(), numbers.end()};
}

// A matrix as a list of rows.
template <typename Matrix>
Json JsonRows(const Matrix& matrix) {
  Json rows = Json::array();
  for (const auto& row : matrix.rowwise()) rows.push_back(RowMajor(row));
  return rows;
}

// The shortest text that reads back as the same bits, with a decimal point or
// an exponent so that no language takes it for an integer.
std::string DecimalText(double value);

// "[1.0, 2.0]", row by row.
template <typename Matrix>
std::string DecimalList(const Matrix& matrix) {
  std::string text;
  for (const double number : RowMajor(matrix)) {
    text += (text.empty() ? "[" : ", ") + DecimalText(number);
  }
  return text + "]";
}

// Rodrigues vector [rad] of a rotation.
Eigen::Vector3d RotationVector(const Eigen::Matrix3d& R);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_WRITE_FORMATS_H_
