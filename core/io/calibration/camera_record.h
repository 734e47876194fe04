// Interface between ReadCameras and the readers of the individual formats. For
// core/io only.
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

// One camera in the conventions of its file. Readers have checked only that
// arrays have the right shape and that numbers are finite.
struct CameraRecord {
  std::string file;  // for messages
  std::string name;
  int64_t width_px = 0;  // 0: unknown
  int64_t height_px = 0;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  // K refers to coordinates divided by the image size.
  bool normalised_K = false;
  // width_px and height_px are those of the sensor, or of the part of it that
  // the video shows; images may show the same part at another resolution.
  // cameras.image_size may therefore differ if its aspect ratio is the same.
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
  LengthUnit unit = LengthUnit::kMetre;  // of the file; never kAuto
  // The unit is certain, and cameras.unit cannot change it: the file states it,
  // or the format prescribes it (kinegraph, Qualisys, Vicon, OptiTrack).
  bool states_unit = false;
};

// Row-major numbers as a matrix.
Eigen::Matrix3d ToMatrix3(const std::vector<double>& row_major);
Eigen::Vector3d ToVector3(const std::vector<double>& numbers);
// K without skew, from fx, fy, cx, cy.
Eigen::Matrix3d CameraMatrix(const std::vector<double>& numbers);
// The rotation of a quaternion whose length is 1 up to the rounding of a text
// file; nullopt otherwise.
std::optional<Eigen::Matrix3d> RotationOf(const Eigen::Quaterniond& turn);

// A rotation that is given as a Rodrigues vector [rad] or a 3 x 3 matrix.
Eigen::Matrix3d ReadRotation(const JsonField& field);

// Reads the members of one object and records which were read. An unknown key
// may be the lens or the pose under another name, and ignoring it would
// silently distort all results. So a key that is not read is rejected, unless
// it is known to describe neither lens nor pose:
//
//   KeyReader keys(camera);
//   record.K = keys.Matrix3("K");
//   keys.ReadLens(&record);
//   keys.RejectUnread();
class KeyReader {
 public:
  // `object` is not owned. Throws InputError if it is not an object.
  explicit KeyReader(const JsonField& object);

  const JsonField& object() const { return object_; }
  // Like JsonField's functions; they also mark the key as read.
  std::optional<JsonField> Find(const std::string& key);
  JsonField At(const std::string& key);
  // The first of these spellings that occurs in the object. Only this one is
  // marked as read: a second one is rejected unless the caller reads it, too.
  JsonField AtAny(const std::vector<std::string>& keys);
  Eigen::Matrix3d Matrix3(const std::string& key) {
    return ToMatrix3(At(key).Matrix(3, 3));
  }
  Eigen::Vector3d Vector3(const std::string& key) {
    return ToVector3(At(key).Matrix(3, 1));
  }

  // Reads width and height, as a pair or each under its own key. Leaves
  // `record` unchanged if the object does not specify them.
  void ReadImageSize(const std::string& key, CameraRecord* record);
  void ReadImageSize(const std::string& width, const std::string& height,
                     CameraRecord* record);

  // Reads the lens under any common name: a list "distCoeffs", "dist_coef",
  // "dist", "D", "distortion_coefficients", ... in OpenCV's order; lists "k"
  // (3) and "p" (2); or numbers "k1" .. "k6", "p1", "p2". If several are
  // present, they must agree. The model ("camera_model", "distortion_model",
  // ...) must be a pinhole, OpenCV's polynomial or OpenCV's fisheye model,
  // whose terms are k1 k2 k3 k4 in this order; "fisheye": true specifies the
  // fisheye model, too. Throws InputError for another model, for
  // "omnidirectional": true and for coefficients that do not agree. Leaves
  // `record` unchanged if there are neither coefficients nor a fisheye model.
  void ReadLens(CameraRecord* record);

  // Reads "unit" or "units": m, cm or mm, or their names. Leaves `file`
  // unchanged if there is neither.
  void ReadUnit(CalibrationFile* file);

  // Throws InputError for the first key that was not read and is not harmless
  // (IsHarmlessKey).
  void RejectUnread() const;

 private:
  void ReadCoefficients(bool is_fisheye,
                        std::vector<std::vector<double>>* lenses);

  JsonField object_;
  std::set<std::string> read_;
};

// Whether a key describes neither lens nor pose in any format: names, dates,
// sizes, errors, boards; or begins with '_'. Ignores case, '_', '-' and spaces.
bool IsHarmlessKey(const std::string& key);
// Throws InputError for a key that may describe lens or pose.
[[noreturn]] void FailUnread(const JsonField& object, const std::string& key);

// Whether a member of an object with one member per camera is not a camera:
// neither object nor array, under a harmless key or "unit" or "units".
bool IsNoCamera(const std::string& key, const JsonField& field);

// Reads an object with one member per camera. `read` fills in the record, whose
// file and name are set, and has to read every key.
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

// Reads one camera, to which messages refer by `name`; `read` is as in
// ReadMembers.
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
