// What the keys of a calibration mean. A key that nobody reads could be the
// lens or the pose under another name, and leaving it out would bend every
// result without a word. So each key is read, or known to say nothing of lens
// and pose, or refused. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_KEYS_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_KEYS_H_

#include <set>
#include <string>
#include <vector>

#include "core/io/calibration/formats.h"
#include "core/io/text/json.h"

namespace kinegraph {

// Reads the members of one object and remembers which it has read:
//
//   KeyReader keys(camera);
//   record.K = ToMatrix3(keys.At("K").Matrix(3, 3));
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
  std::optional<JsonField> FindAny(const std::vector<std::string>& keys);
  JsonField AtAny(const std::vector<std::string>& keys);

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

// Whether a member of an object of cameras is none: a number or text of one of
// those names, or the unit.
bool IsNoCamera(const std::string& key, const JsonField& field);

// A rotation as a Rodrigues vector or a matrix.
Eigen::Matrix3d ReadRotation(const JsonField& field);

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

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_KEYS_H_
