// The formats of calibrations: one entry each, from which follow recognition,
// the key cameras.format, `convert --formats` and its flags, and the formats
// that the Python module writes. A format joins by its functions and by two
// lines in format.cc.
#ifndef KINEGRAPH_CORE_IO_CALIBRATION_FORMAT_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_FORMAT_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/io/adapters/adapter.h"
#include "core/io/calibration/camera_record.h"
#include "core/io/text/json.h"
#include "core/io/text/lost_fields.h"
#include "core/io/text/xml_file.h"

namespace kinegraph {

// How the text of a calibration is written.
enum class CalibrationSyntax { kJson, kToml, kYaml, kXml, kNumbers, kOther };

// What a path looks like, for recognising its format and for reading it.
struct CalibrationHead {
  std::string path;
  bool is_folder = false;
  std::vector<std::string> names;  // in the folder, sorted
  // The rest is of a file.
  CalibrationSyntax syntax = CalibrationSyntax::kOther;
  Json json;  // of JSON and TOML; of YAML for recognising alone
  std::optional<XmlElement> xml;  // the outermost element of XML

  bool Is(CalibrationSyntax of_file) const {
    return !is_folder && syntax == of_file;
  }
  // The file is JSON, an object that has the key.
  bool HasJsonKey(const std::string& key) const;
  // The folder has a file of that name.
  bool HasFile(const std::string& name) const;
  JsonField Root() const { return JsonField(json, path); }
  // Throws InputError where the file is no XML.
  const XmlElement& XmlRoot() const;
};

struct CalibrationFormat {
  using Recognise = bool (*)(const CalibrationHead& head);
  using Read = CalibrationFile (*)(const CalibrationHead& head);
  // Writes a file or a folder in the unit of the format; it appears when it is
  // complete. What changes the geometry and cannot be said (a lens in TUM's
  // matrices, a skewed K in VoxelPose's) throws InputError naming the camera;
  // what is merely left out is added to `lost_fields`.
  using Write = void (*)(const std::string& path, const CameraRig& cameras,
                         LostFields* lost_fields);

  std::string name;
  std::string layout;  // one line for people
  CalibrationSyntax syntax = CalibrationSyntax::kJson;
  Recognise recognise = nullptr;  // null: an adapter does
  Read read = nullptr;
  Write write = nullptr;  // null: read only
};

const std::vector<CalibrationFormat>& CalibrationFormats();
// nullptr when there is none of that name.
const CalibrationFormat* FindCalibrationFormat(const std::string& name);

// Looks at a path; throws InputError when it cannot be read or parsed.
CalibrationHead LookAtCalibration(const std::string& path);
// The same where the format is known, whatever the text looks like.
CalibrationHead LookAtCalibration(const std::string& path,
                                  const CalibrationFormat& format);
// The format that recognises it, or nullptr.
const CalibrationFormat* RecogniseCalibration(const CalibrationHead& head);
// Whether a folder is a calibration by the names of its files.
bool IsCalibrationFolder(const std::string& path);

// What an adapter prints of a path: our own format, in any unit.
CalibrationFile ReadByAdapter(const Adapter& adapter, const std::string& path);

// Reads the file that was given, or these of its folder, each of one camera.
CalibrationFile ReadFileACamera(const CalibrationHead& head,
                                const std::vector<std::string>& files,
                                LengthUnit unit,
                                CameraRecord (*read)(const std::string& path));
bool IsYamlName(const std::string& name);
Json ReadCalibrationYaml(const std::string& path);
// Whether P0.txt, P1.txt, ... are among the names of a folder's files.
bool HasTumFiles(const std::vector<std::string>& names);

// Writes a file or a folder in a format of that name. Throws InputError where
// there is none.
void WriteCalibration(const std::string& path, const std::string& format,
                      const CameraRig& cameras, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_FORMAT_H_
