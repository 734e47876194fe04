// What the readers of single calibration formats hand to ReadCameras, and how
// they read it. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_CAMERA_RECORD_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_CAMERA_RECORD_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/calibration/calibration.h"
#include "core/io/text/json.h"

namespace kinegraph {

// One camera in the words of its file: nothing is checked yet but shapes and
// that numbers are finite.
struct CameraRecord {
  std::string file;  // for messages
  std::string name;
  int64_t width_px = 0;  // 0: not told
  int64_t height_px = 0;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  // K belongs to coordinates divided by the image size.
  bool normalised_K = false;
  // The size is that of the sensor: a picture of another size and the same
  // proportions (cameras.image_size) is the whole of it, scaled.
  bool may_be_scaled = false;
  std::string lens_model = "opencv5";
  std::vector<double> distortion;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // cam_from_world
  // cam_from_world, in the file's unit; meaningless when `centre` is given.
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  // Position of the camera in the world, in the file's unit.
  std::optional<Eigen::Vector3d> centre;
};

struct CalibrationFile {
  std::vector<CameraRecord> cameras;
  LengthUnit unit = LengthUnit::kMetre;  // the format's own
  bool states_unit = false;              // it cannot be another one
};

// Row-major numbers as a matrix.
Eigen::Matrix3d ToMatrix3(const std::vector<double>& row_major);
Eigen::Vector3d ToVector3(const std::vector<double>& numbers);
// K without skew, of fx, fy, cx, cy.
Eigen::Matrix3d CameraMatrix(const std::vector<double>& numbers);
// The rotation of a quaternion w, x, y, z that a file writes with a dozen
// digits; nullopt where it is none of unit length.
std::optional<Eigen::Matrix3d> RotationOf(const Eigen::Quaterniond& turn);

// A rotation as a Rodrigues vector or a matrix.
Eigen::Matrix3d ReadRotation(const JsonField& field);

// Reads the members of one object and remembers which it has read. A key that
// nobody reads could be the lens or the pose under another name, and leaving it
// out would bend every result without a word. So each key is read, or known to
// say nothing of lens and pose, or refused:
//
//   KeyReader keys(camera);
//   record.K = keys.Matrix3("K");
//   keys.ReadLens(&record);
//   keys.RejectUnread();
class KeyReader {
 public:
  // `object` is not owned. Throws InputError when it is no object.
  explicit KeyReader(const JsonField& object);

  const JsonField& object() const { return object_; }
  // As JsonField's; the key counts as read.
  std::optional<JsonField> Find(const std::string& key);
  JsonField At(const std::string& key);
  // The first of several spellings that the object has. Only it counts as
  // read: a second one is refused unless the caller reads it, too.
  JsonField AtAny(const std::vector<std::string>& keys);
  Eigen::Matrix3d Matrix3(const std::string& key) {
    return ToMatrix3(At(key).Matrix(3, 3));
  }
  Eigen::Vector3d Vector3(const std::string& key) {
    return ToVector3(At(key).Matrix(3, 1));
  }

  // Width and height as a pair, or each under a key of its own; left alone
  // where the object does not tell them.
  void ReadImageSize(const std::string& key, CameraRecord* record);
  void ReadImageSize(const std::string& width, const std::string& height,
                     CameraRecord* record);

  // The lens under any name that programs give it: a list "distCoeffs",
  // "dist_coef", "dist", "D", "distortion_coefficients", ... in OpenCV's order;
  // lists "k" (3) and "p" (2); or numbers "k1" .. "k6", "p1", "p2".
  // Several names must say the same. The name of a model ("camera_model",
  // "distortion_model", ...) must be a pinhole, OpenCV's polynomial or its
  // fisheye model, whose terms are k1 k2 k3 k4 in this order; "fisheye": true
  // says the latter, too. Leaves `record` alone when nothing is said.
  void ReadLens(CameraRecord* record);

  // "unit" or "units" as the text m, cm or mm (or their names).
  void ReadUnit(CalibrationFile* file);

  // Throws for the first key that was not read and is not one of those that
  // programs write beside lens and pose (names, dates, sizes, errors, boards).
  void RejectUnread() const;

 private:
  void ReadCoefficients(bool is_fisheye,
                        std::vector<std::vector<double>>* lenses);

  JsonField object_;
  std::set<std::string> read_;
};

// Whether a key says nothing of lens and pose, whatever the format: names,
// dates, sizes, errors, boards. Letter case, '_', '-' and spaces do not count.
bool IsHarmlessKey(const std::string& key);
// Refuses a key that could say something of them.
[[noreturn]] void FailUnread(const JsonField& object, const std::string& key);

// Whether a member of an object of cameras is none: a number or text of one of
// those names, or the unit.
bool IsNoCamera(const std::string& key, const JsonField& field);

// Reads each member of an object of cameras: `read` fills in the record, whose
// file and name are set, and every key must have been read afterwards.
template <typename Read>
void ReadMembers(const JsonField& cameras, CalibrationFile* file,
                 const Read& read) {
  for (const auto& [name, field] : cameras.Members("camera")) {
    if (IsNoCamera(name, field)) continue;
    KeyReader camera(field);
    CameraRecord& record = file->cameras.emplace_back();
    record.file = cameras.file();
    record.name = name;
    read(&camera, &record);
    camera.RejectUnread();
  }
}

// A camera of a list, which names itself under "name".
template <typename Read>
CameraRecord ReadNamed(const JsonField& field, const std::string& name,
                       const Read& read) {
  CameraRecord record;
  record.file = field.file();
  record.name = name;
  KeyReader camera(field.Named("camera '" + Printable(name) + "'"));
  read(&camera, &record);
  camera.RejectUnread();
  return record;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_CAMERA_RECORD_H_
