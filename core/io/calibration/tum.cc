// Projection matrices P0.txt, P1.txt, ... as TUM publishes them for Campus and
// Shelf: 3x4 numbers separated by spaces or commas, metres. P is known up to
// scale and sign.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "core/base/error.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/write_formats.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/text/words.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// P = s K [R | t] with K upper triangular, its diagonal positive and
// K(2,2) = 1, and det R = +1, which fixes the sign of s (Hartley and Zisserman,
// Multiple View Geometry, section 6.2.4). The RQ decomposition comes from the
// QR decomposition of the matrix with rows and columns reversed.
void Decompose(const Eigen::Matrix<double, 3, 4>& P, CameraRecord* record) {
  const Eigen::Matrix3d M = P.leftCols<3>();
  const double largest = M.cwiseAbs().maxCoeff();
  const double determinant = (M / largest).determinant();
  // Pixels per unit of M's last row: a determinant this small is rounding.
  if (!(largest > 0.0) || !(std::abs(determinant) > 1e-12)) {
    throw InputError(record->file, "",
                     "the left 3 x 3 part of the projection is singular");
  }
  const double sign = determinant < 0.0 ? -1.0 : 1.0;
  Eigen::Matrix3d reversal;
  reversal << 0, 0, 1, 0, 1, 0, 1, 0, 0;
  const Eigen::Matrix3d flipped = (reversal * (sign * M)).transpose();
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr(flipped);
  const Eigen::Matrix3d upper =
      qr.matrixQR().triangularView<Eigen::Upper>().toDenseMatrix();
  const Eigen::Matrix3d Q = qr.householderQ();
  Eigen::Matrix3d K = reversal * upper.transpose() * reversal;
  Eigen::Matrix3d R = reversal * Q.transpose();
  for (int i = 0; i < 3; ++i) {
    if (K(i, i) < 0.0) {
      K.col(i) = -K.col(i);
      R.row(i) = -R.row(i);
    }
  }
  record->t = K.triangularView<Eigen::Upper>().solve(sign * P.col(3));
  record->K = K / K(2, 2);
  record->R = R;
}

// "P12.txt" -> 12, as text without leading zeros; empty when it is no such
// name.
std::string NumberOf(const std::string& file_name) {
  constexpr const char* kDigits = "0123456789";
  const std::string end = ".txt";
  if (file_name.size() < end.size() + 2 || file_name[0] != 'P' ||
      file_name.substr(file_name.size() - end.size()) != end) {
    return {};
  }
  std::string number = file_name.substr(1, file_name.size() - 1 - end.size());
  if (number.find_first_not_of(kDigits) != std::string::npos) return {};
  number.erase(0, std::min(number.find_first_not_of('0'), number.size() - 1));
  return number;
}

CameraRecord ReadTumCamera(const fs::path& path) {
  CameraRecord record;
  record.file = path.string();
  record.name = path.stem().string();
  const std::vector<double> numbers =
      ReadNumberTable(record.file, 12, "a 3 x 4 projection matrix");
  Decompose(Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(
                numbers.data()),
            &record);
  return record;
}

// Names of P*.txt among others, by number.
std::vector<std::string> TumFilesAmong(
    const std::vector<std::string>& all_names) {
  std::vector<std::pair<std::string, std::string>> numbered;
  for (const std::string& name : all_names) {
    const std::string number = NumberOf(name);
    if (!number.empty()) numbered.emplace_back(number, name);
  }
  std::sort(numbered.begin(), numbered.end(), [](const auto& a, const auto& b) {
    if (a.first.size() != b.first.size()) {
      return a.first.size() < b.first.size();
    }
    return a < b;
  });
  std::vector<std::string> names;
  for (const auto& entry : numbered) names.push_back(entry.second);
  return names;
}

bool RecogniseTum(const CalibrationHead& head) {
  return head.is_folder ? HasTumFiles(head.names)
                        : head.Is(CalibrationSyntax::kNumbers) &&
                              fs::path(head.path).extension() != ".calib";
}

CalibrationFile ReadTum(const CalibrationHead& head) {
  CalibrationFile file;
  if (!head.is_folder) {
    file.cameras.push_back(ReadTumCamera(head.path));
    return file;
  }
  for (const std::string& name : TumFilesAmong(head.names)) {
    file.cameras.push_back(ReadTumCamera(fs::path(head.path) / name));
  }
  if (file.cameras.empty()) {
    throw InputError(head.path, "", "has no files P0.txt, P1.txt, ...");
  }
  return file;
}

void WriteTum(const std::string& path, const CameraRig& cameras,
              LostFields* lost_fields) {
  AtomicFolder folder(path);
  bool has_size = false;
  bool renames = false;
  for (size_t c = 0; c < cameras.size(); ++c) {
    const Camera& camera = cameras[c];
    if (camera.lens() != nullptr) {
      throw CannotWrite(camera,
                        "has a lens, which a projection matrix cannot say "
                        "(cameras.ignore_distortion = true leaves it out)");
    }
    const std::string name = "P" + std::to_string(c);
    AtomicFile file(folder.PathOf(name + ".txt"));
    for (int r = 0; r < 3; ++r) {
      for (int k = 0; k < 4; ++k) {
        file.Write(DecimalText(camera.P()(r, k)) + (k < 3 ? "," : "\n"));
      }
    }
    file.Commit();
    has_size = has_size || HasSize(camera);
    renames = renames || camera.name() != name;
  }
  folder.Commit();
  if (has_size) lost_fields->push_back("image sizes are not kept");
  if (renames) {
    lost_fields->push_back(
        "cameras are named P0, P1, ... in the order of the input");
  }
}

}  // namespace

bool HasTumFiles(const std::vector<std::string>& names) {
  return std::any_of(names.begin(), names.end(), [](const std::string& name) {
    return !NumberOf(name).empty();
  });
}

CalibrationFormat TumCalibrationFormat() {
  CalibrationFormat format;
  format.name = "tum";
  format.layout = "a folder of P0.txt, P1.txt, ...";
  format.syntax = CalibrationSyntax::kNumbers;
  format.recognise = RecogniseTum;
  format.read = ReadTum;
  format.write = WriteTum;
  format.written_as = "folder";
  format.kept = "the projection, to 1e-11 when taken apart again";
  format.lost = "lost: image sizes, names; refused: a lens";
  return format;
}

}  // namespace kinegraph
