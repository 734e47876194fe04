// The table of calibration formats. Recognition, the key cameras.format,
// `convert` with --from, --to and --formats, and the formats of the Python
// module are derived from it. A new format requires its functions and two lines
// in format.cc.
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

// Syntax of a calibration's text.
enum class CalibrationSyntax { kJson, kToml, kYaml, kXml, kNumbers, kOther };

// A path's content, as far as it is needed to recognise its format. For XML,
// JSON and TOML it is the whole content.
struct CalibrationHead {
  std::string path;
  bool is_folder = false;
  std::vector<std::string> names;  // in the folder, not hidden; sorted
  // The rest applies to files.
  CalibrationSyntax syntax = CalibrationSyntax::kOther;
  // Content of JSON and TOML files; of YAML files only if the format is still
  // to be recognised, because readers of YAML parse the file themselves.
  Json json;
  std::optional<XmlElement> xml;  // root element of XML

  bool Is(CalibrationSyntax of_file) const {
    return !is_folder && syntax == of_file;
  }
  // The file is a JSON object with this key.
  bool HasJsonKey(const std::string& key) const;
  // The folder contains a file of this name.
  bool HasFile(const std::string& name) const;
  JsonField Root() const { return JsonField(json, path); }
  // Throws InputError if the file is not XML.
  const XmlElement& XmlRoot() const;
};

struct CalibrationFormat {
  using Recognise = bool (*)(const CalibrationHead& head);
  using Read = CalibrationFile (*)(const CalibrationHead& head);
  // Writes a file or a folder in the format's unit; it appears only when
  // complete. Throws InputError naming the camera if the format cannot
  // represent it (a lens in TUM's matrices, a skewed K in VoxelPose's, an
  // unknown image size in COLMAP's); adds other omissions to `lost_fields`.
  using Write = void (*)(const std::string& path, const CameraRig& cameras,
                         LostFields* lost_fields);

  std::string name;
  std::string layout;  // one line for users
  CalibrationSyntax syntax = CalibrationSyntax::kJson;
  Recognise recognise = nullptr;  // null: an adapter recognises it
  Read read = nullptr;
  Write write = nullptr;  // null: read only
};

const std::vector<CalibrationFormat>& CalibrationFormats();
// nullptr if there is none of this name.
const CalibrationFormat* FindCalibrationFormat(const std::string& name);

// Reads a path; throws InputError if it cannot be read or parsed.
CalibrationHead LookAtCalibration(const std::string& path);
// The same for a given format, without recognition of the syntax.
CalibrationHead LookAtCalibration(const std::string& path,
                                  const CalibrationFormat& format);
// The first format that recognises `head`, or nullptr.
const CalibrationFormat* RecogniseCalibration(const CalibrationHead& head);
// Whether a folder contains a calibration: by the names of its files and, for
// OpenCap, of those in its subfolders, or by the content of a config.toml.
bool IsCalibrationFolder(const std::string& path);

// Reads what an adapter prints for a path: kinegraph's own format, in any unit.
// states_unit is false even if the adapter prints a unit, which it only
// assumes: cameras.unit may override it.
CalibrationFile ReadByAdapter(const Adapter& adapter, const std::string& path);

// Reads files with one camera each, in `unit`: the path of `head` if it is a
// file, otherwise `files` in that folder.
CalibrationFile ReadFileACamera(const CalibrationHead& head,
                                const std::vector<std::string>& files,
                                LengthUnit unit,
                                CameraRecord (*read)(const std::string& path));
bool IsYamlName(const std::string& name);
Json ReadCalibrationYaml(const std::string& path);
// Whether the names include P0.txt, P1.txt, ...
bool HasTumFiles(const std::vector<std::string>& names);

// Writes a file or a folder in the format of this name. Throws InputError if
// there is none, or if it can only be read.
void WriteCalibration(const std::string& path, const std::string& format,
                      const CameraRig& cameras, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_FORMAT_H_
