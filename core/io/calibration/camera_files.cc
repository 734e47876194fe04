// Calibrations with one file per camera: TUM's projection matrices, bioCV's
// tables of numbers, and OpenCap's pickles, which an adapter reads.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/calibration/format.h"
#include "core/io/calibration/write_formats.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/text/names.h"
#include "core/io/text/words.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// ---- TUM ----
// Projection matrices P0.txt, P1.txt, ... as TUM publishes them for Campus and
// Shelf: 3x4 numbers separated by spaces or commas, metres. P is known up to
// scale and sign.

// Decomposes P = s K [R | t] such that K is upper triangular with positive
// diagonal and K(2,2) = 1, and det R = +1, which determines the sign of s
// (Hartley and Zisserman, Multiple View Geometry, section 6.2.4). The RQ
// decomposition comes from the QR decomposition of the transposed matrix with
// its columns reversed.
void Decompose(const Eigen::Matrix<double, 3, 4>& P, CameraRecord* record) {
  const Eigen::Matrix3d M = P.leftCols<3>();
  const double largest = M.cwiseAbs().maxCoeff();
  const double determinant = (M / largest).determinant();
  // A determinant below 1e-12 of the largest element's cube is rounding error.
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

// Whether the name is like "P12.txt".
bool IsTumName(const std::string& name) {
  return name.size() > 5 && name[0] == 'P' && EndsIn(name, ".txt") &&
         name.find_first_not_of("0123456789", 1) == name.size() - 4;
}

// The names that `is_one` accepts, in natural order (2 before 10).
std::vector<std::string> Sorted(const std::vector<std::string>& names,
                                bool (*is_one)(const std::string& name)) {
  std::vector<std::string> files;
  std::copy_if(names.begin(), names.end(), std::back_inserter(files), is_one);
  std::sort(files.begin(), files.end(), NaturalLess);
  return files;
}

CameraRecord ReadTumCamera(const std::string& path) {
  CameraRecord record;
  record.file = path;
  record.name = fs::path(path).stem().string();
  const std::vector<double> numbers =
      ReadNumberTable(path, 12, "a 3 x 4 projection matrix");
  Decompose(Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(
                numbers.data()),
            &record);
  return record;
}

}  // namespace

bool HasTumFiles(const std::vector<std::string>& names) {
  return std::any_of(names.begin(), names.end(), IsTumName);
}

bool RecogniseTum(const CalibrationHead& head) {
  return head.is_folder ? HasTumFiles(head.names)
                        : head.Is(CalibrationSyntax::kNumbers) &&
                              fs::path(head.path).extension() != ".calib";
}

CalibrationFile ReadTum(const CalibrationHead& head) {
  const std::vector<std::string> files = Sorted(head.names, IsTumName);
  if (head.is_folder && files.empty()) {
    throw InputError(head.path, "", "has no files P0.txt, P1.txt, ...");
  }
  return ReadFileACamera(head, files, LengthUnit::kMetre, ReadTumCamera);
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
                        "has a lens, which a projection matrix cannot express "
                        "(cameras.ignore_distortion = true omits it)");
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

// ---- bioCV ----
// bioCV's .calib, one file per camera: numbers separated by spaces and line
// ends: the image's width and height, K (3x3 px, row-major), the pose (4x4,
// row-major: x_cam = R X + t, mm) and OpenCV's k1 k2 p1 p2 k3. "00.mp4.calib"
// is camera "00".

namespace {

constexpr const char* kExtension = ".calib";

bool IsCalib(const std::string& name) {
  return fs::path(name).extension() == kExtension;
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

}  // namespace

bool RecogniseBiocv(const CalibrationHead& head) {
  if (head.is_folder) {
    return std::any_of(head.names.begin(), head.names.end(), IsCalib) &&
           !HasTumFiles(head.names);
  }
  return IsCalib(head.path) && (head.Is(CalibrationSyntax::kNumbers) ||
                                head.Is(CalibrationSyntax::kOther));
}

CalibrationFile ReadBiocv(const CalibrationHead& head) {
  return ReadFileACamera(head, Sorted(head.names, IsCalib),
                         LengthUnit::kMillimetre, ReadBiocvCamera);
}

// ---- OpenCap ----
// Python pickles, read by an adapter: one per camera, in Videos/CAMERA of a
// session's folder. The path may be that folder, its subfolder Videos, or the
// folder of one camera.

bool IsOpencapFolder(const std::string& path) {
  constexpr const char* kPickle = "cameraIntrinsicsExtrinsics.pickle";
  const fs::path folder = path;
  if (IsFile((folder / kPickle).string())) return true;
  for (const fs::path& parent : {folder / "Videos", folder}) {
    if (!IsFolder(parent.string())) continue;
    for (const std::string& camera : ListFolder(parent.string())) {
      if (IsFile((parent / camera / kPickle).string())) return true;
    }
  }
  return false;
}

CalibrationFile ReadOpencap(const CalibrationHead& head) {
  return ReadByAdapter(OwnAdapter("opencap", AdapterKind::kCameras), head.path);
}

}  // namespace kinegraph
