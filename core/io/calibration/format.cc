#include "core/io/calibration/format.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/text/toml_file.h"
#include "core/io/text/words.h"

namespace kinegraph {

// Declares the functions that a format may have; other sources of this folder
// define those that the table below uses.
#define KINEGRAPH_DECLARE(Format)                                       \
  bool Recognise##Format(const CalibrationHead& head);                  \
  CalibrationFile Read##Format(const CalibrationHead& head);            \
  void Write##Format(const std::string& path, const CameraRig& cameras, \
                     LostFields* lost_fields)
KINEGRAPH_DECLARE(Kinegraph);
KINEGRAPH_DECLARE(Krt);
KINEGRAPH_DECLARE(Voxelpose);
KINEGRAPH_DECLARE(Longcw);
KINEGRAPH_DECLARE(Panoptic);
KINEGRAPH_DECLARE(Pose2sim);
KINEGRAPH_DECLARE(Tum);
KINEGRAPH_DECLARE(Opencv);
KINEGRAPH_DECLARE(Easymocap);
KINEGRAPH_DECLARE(Colmap);
KINEGRAPH_DECLARE(Qualisys);
KINEGRAPH_DECLARE(Vicon);
KINEGRAPH_DECLARE(Optitrack);
KINEGRAPH_DECLARE(Biocv);
#undef KINEGRAPH_DECLARE
CalibrationFile ReadOpencap(const CalibrationHead& head);
bool IsOpencapFolder(const std::string& path);

namespace {

namespace fs = std::filesystem;

using Syntax = CalibrationSyntax;

CalibrationHead LookAtFolder(const std::string& path) {
  CalibrationHead head;
  head.path = path;
  head.is_folder = true;
  // macOS adds a hidden file to each file on other file systems.
  for (std::string& name : ListFolder(path)) {
    if (name.front() != '.') head.names.push_back(std::move(name));
  }
  return head;
}

// Parses XML, JSON or TOML; for other syntaxes sets only path and syntax.
CalibrationHead Parsed(const std::string& path, Syntax syntax,
                       const std::string& text) {
  CalibrationHead head;
  head.path = path;
  head.syntax = syntax;
  if (syntax == Syntax::kXml) head.xml = ParseXml(text, path);
  if (syntax == Syntax::kJson) head.json = ParseJson(text, path);
  if (syntax == Syntax::kToml) head.json = ToJson(ParseToml(text, path));
  return head;
}

bool IsUtf16(const std::string& text) {
  return text.rfind("\xFF\xFE", 0) == 0 || text.rfind("\xFE\xFF", 0) == 0;
}

// Whether the first character of a UTF-16 text, of either byte order, is "<".
bool IsUtf16Xml(const std::string& text) {
  const size_t first =
      text.find_first_not_of(std::string_view("\xFF\xFE\0 \t\r\n", 7));
  return first != std::string::npos && text[first] == '<';
}

// Guesses the syntax from the text and the extension. Throws InputError if the
// text is blank.
Syntax GuessSyntax(const std::string& text, const std::string& path) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) {
    throw InputError(path, "", "is empty, expected a calibration");
  }
  if (text[first] == '{') return Syntax::kJson;
  if (text[first] == '<') return Syntax::kXml;
  const std::string extension = fs::path(path).extension().string();
  if (text[first] == '%' || IsYamlName(path)) return Syntax::kYaml;
  if (IsNumberTable(text)) return Syntax::kNumbers;
  if (extension == ".json") return Syntax::kJson;
  if (text[first] == '[' || extension == ".toml" ||
      text.find("\n[") != std::string::npos) {
    return Syntax::kToml;
  }
  return Syntax::kOther;
}

}  // namespace

// `convert --formats` lists them in this order. No two formats recognise the
// same file. A folder with files of several formats is read in the first of
// these formats.
const std::vector<CalibrationFormat>& CalibrationFormats() {
  static const std::vector<CalibrationFormat> kFormats = {
      {"kinegraph", "cameras.json", Syntax::kJson, RecogniseKinegraph,
       ReadKinegraph, WriteKinegraph},
      {"krt", "JSON: K and RT of each camera", Syntax::kJson, RecogniseKrt,
       ReadKrt, WriteKrt},
      {"voxelpose", "JSON, mm", Syntax::kJson, RecogniseVoxelpose,
       ReadVoxelpose, WriteVoxelpose},
      {"longcw", "JSON, cm", Syntax::kJson, RecogniseLongcw, ReadLongcw,
       WriteLongcw},
      {"panoptic", "CMU Panoptic's JSON, cm", Syntax::kJson, RecognisePanoptic,
       ReadPanoptic, WritePanoptic},
      {"pose2sim", "TOML: Pose2Sim, Anipose, FreeMoCap, Caliscope",
       Syntax::kToml, RecognisePose2sim, ReadPose2sim, WritePose2sim},
      {"tum", "a folder of P0.txt, P1.txt, ...", Syntax::kNumbers, RecogniseTum,
       ReadTum, WriteTum},
      {"opencv", "YAML, one file per camera", Syntax::kYaml, RecogniseOpencv,
       ReadOpencv, WriteOpencv},
      {"easymocap", "intri.yml and extri.yml", Syntax::kYaml,
       RecogniseEasymocap, ReadEasymocap, WriteEasymocap},
      {"colmap",
       "COLMAP's text: cameras.txt and images.txt, one image per camera",
       Syntax::kOther, RecogniseColmap, ReadColmap, WriteColmap},
      {"qualisys", "XML: QTM's .qca.txt, and cal.txt as exported for Theia",
       Syntax::kXml, RecogniseQualisys, ReadQualisys},
      {"vicon", "XML: .xcp of Nexus, Shogun or Tracker", Syntax::kXml,
       RecogniseVicon, ReadVicon},
      {"optitrack", "XML: .mcal of Motive 3", Syntax::kXml, RecogniseOptitrack,
       ReadOptitrack},
      {"opencap",
       "a session's folder, one cameraIntrinsicsExtrinsics.pickle per camera",
       Syntax::kOther, nullptr, ReadOpencap},
      {"biocv", "bioCV's .calib, one file per camera", Syntax::kNumbers,
       RecogniseBiocv, ReadBiocv}};
  return kFormats;
}

const CalibrationFormat* FindCalibrationFormat(const std::string& name) {
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

bool CalibrationHead::HasJsonKey(const std::string& key) const {
  return Is(Syntax::kJson) && json.is_object() && json.contains(key);
}

const XmlElement& CalibrationHead::XmlRoot() const {
  if (!xml.has_value()) throw InputError(path, "", "expected an XML file");
  return *xml;
}

bool CalibrationHead::HasFile(const std::string& name) const {
  return std::binary_search(names.begin(), names.end(), name);
}

CalibrationHead LookAtCalibration(const std::string& path) {
  if (IsFolder(path)) return LookAtFolder(path);
  std::string text = ReadBytes(path, kMaxSmallFileBytes);
  // UTF-16 is accepted only for XML, which specifies its encoding.
  if (IsUtf16(text) && IsUtf16Xml(text)) {
    return Parsed(path, Syntax::kXml, text);
  }
  MakePlainText(path, &text);
  CalibrationHead head = Parsed(path, GuessSyntax(text, path), text);
  if (head.syntax == Syntax::kYaml) head.json = ReadCalibrationYaml(path);
  return head;
}

CalibrationHead LookAtCalibration(const std::string& path,
                                  const CalibrationFormat& format) {
  if (IsFolder(path)) return LookAtFolder(path);
  if (format.syntax == Syntax::kXml) {
    return Parsed(path, format.syntax, ReadBytes(path, kMaxSmallFileBytes));
  }
  const bool is_parsed =
      format.syntax == Syntax::kJson || format.syntax == Syntax::kToml;
  return Parsed(path, format.syntax,
                is_parsed ? ReadTextFile(path, kMaxSmallFileBytes) : "");
}

bool IsYamlName(const std::string& name) {
  const std::string extension = fs::path(name).extension().string();
  return extension == ".yml" || extension == ".yaml";
}

Json ReadCalibrationYaml(const std::string& path) {
  // 4 MiB suffice for four thousand cameras; limited because the parser is
  // slow.
  constexpr size_t kMaxBytes = size_t{4} << 20;
  return ParseYaml(ReadTextFile(path, kMaxBytes), path);
}

CalibrationFile ReadFileACamera(const CalibrationHead& head,
                                const std::vector<std::string>& files,
                                LengthUnit unit,
                                CameraRecord (*read)(const std::string& path)) {
  CalibrationFile calibration;
  calibration.unit = unit;
  if (!head.is_folder) {
    calibration.cameras.push_back(read(head.path));
    return calibration;
  }
  for (const std::string& file : files) {
    calibration.cameras.push_back(read((fs::path(head.path) / file).string()));
  }
  return calibration;
}

const CalibrationFormat* RecogniseCalibration(const CalibrationHead& head) {
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.recognise != nullptr && format.recognise(head)) return &format;
  }
  return nullptr;
}

bool IsCalibrationFolder(const std::string& path) {
  return RecogniseCalibration(LookAtFolder(path)) != nullptr ||
         IsOpencapFolder(path);
}

}  // namespace kinegraph
