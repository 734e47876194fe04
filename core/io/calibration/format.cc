#include "core/io/calibration/format.h"

#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/io/calibration/yaml.h"
#include "core/io/files/text_file.h"
#include "core/io/text/pickle.h"
#include "core/io/text/toml_file.h"
#include "core/io/text/words.h"

// One line a format, in the order in which they are listed; no other order
// matters, as no two recognise the same. Each names the function that makes the
// format's entry, which its own file defines.
#define KINEGRAPH_CALIBRATION_FORMATS(FORMAT) \
  FORMAT(KinegraphCalibrationFormat)          \
  FORMAT(KrtCalibrationFormat)                \
  FORMAT(VoxelposeCalibrationFormat)          \
  FORMAT(LongcwCalibrationFormat)             \
  FORMAT(PanopticCalibrationFormat)           \
  FORMAT(Pose2simCalibrationFormat)           \
  FORMAT(TumCalibrationFormat)                \
  FORMAT(OpencvCalibrationFormat)             \
  FORMAT(EasymocapCalibrationFormat)          \
  FORMAT(ColmapCalibrationFormat)             \
  FORMAT(QualisysCalibrationFormat)           \
  FORMAT(ViconCalibrationFormat)              \
  FORMAT(OptitrackCalibrationFormat)          \
  FORMAT(OpencapCalibrationFormat)            \
  FORMAT(BiocvCalibrationFormat)

namespace kinegraph {

#define KINEGRAPH_DECLARE(make) CalibrationFormat make();
KINEGRAPH_CALIBRATION_FORMATS(KINEGRAPH_DECLARE)
#undef KINEGRAPH_DECLARE

namespace {

namespace fs = std::filesystem;

using Syntax = CalibrationSyntax;

CalibrationHead LookAtFolder(const std::string& path) {
  CalibrationHead head;
  head.path = path;
  head.is_folder = true;
  head.names = ListFolder(path);
  return head;
}

bool IsUtf16(const std::string& text) {
  return text.rfind("\xFF\xFE", 0) == 0 || text.rfind("\xFE\xFF", 0) == 0;
}

// What a text looks like, before it is parsed.
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

const std::vector<CalibrationFormat>& CalibrationFormats() {
#define KINEGRAPH_MAKE(make) make(),
  static const std::vector<CalibrationFormat> kFormats = {
      KINEGRAPH_CALIBRATION_FORMATS(KINEGRAPH_MAKE)};
#undef KINEGRAPH_MAKE
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
  if (!xml.has_value()) throw InputError(path, "", "expected a file of XML");
  return *xml;
}

bool CalibrationHead::HasFile(const std::string& name) const {
  return std::binary_search(names.begin(), names.end(), name);
}

bool FirstMemberHas(const Json& json, const std::vector<const char*>& keys) {
  if (!json.is_object() || json.empty()) return false;
  const Json& first = json.front();
  return std::all_of(keys.begin(), keys.end(), [&first](const char* key) {
    return first.is_object() && first.contains(key);
  });
}

bool FirstMemberHas(const CalibrationHead& head,
                    const std::vector<const char*>& keys) {
  return head.Is(Syntax::kJson) && !head.HasJsonKey("cameras") &&
         !head.HasJsonKey("kinegraph_cameras") &&
         FirstMemberHas(head.json, keys);
}

CalibrationHead LookAtCalibration(const std::string& path) {
  if (IsFolder(path)) return LookAtFolder(path);
  CalibrationHead head;
  head.path = path;
  // XML tells its own encoding.
  std::string text = ReadBytes(path, kMaxSmallFileBytes);
  if (IsPickle(text)) {
    head.syntax = Syntax::kPickle;
  } else if (IsUtf16(text)) {
    head.syntax = Syntax::kXml;
  } else {
    MakePlainText(path, &text);
    head.syntax = GuessSyntax(text, path);
  }
  if (head.syntax == Syntax::kXml) head.xml = ParseXml(text, path);
  if (head.syntax == Syntax::kJson) head.json = ParseJson(text, path);
  if (head.syntax == Syntax::kToml) head.json = ToJson(ParseToml(text, path));
  if (head.syntax == Syntax::kYaml) head.json = ReadCalibrationYaml(path);
  return head;
}

CalibrationHead LookAtCalibration(const std::string& path,
                                  const CalibrationFormat& format) {
  CalibrationHead head;
  head.path = path;
  head.syntax = format.syntax;
  if (IsFolder(path)) return LookAtFolder(path);
  if (format.syntax == Syntax::kXml) {
    head.xml = ParseXml(ReadBytes(path, kMaxSmallFileBytes), path);
  }
  if (format.syntax != Syntax::kJson && format.syntax != Syntax::kToml) {
    return head;
  }
  const std::string text = ReadTextFile(path, kMaxSmallFileBytes);
  head.json = format.syntax == Syntax::kJson ? ParseJson(text, path)
                                             : ToJson(ParseToml(text, path));
  return head;
}

const CalibrationFormat* RecogniseCalibration(const CalibrationHead& head) {
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.recognise(head)) return &format;
  }
  return nullptr;
}

bool IsCalibrationFolder(const std::string& path) {
  return RecogniseCalibration(LookAtFolder(path)) != nullptr;
}

std::string TableRow(const CalibrationFormat& format) {
  return "| `" + format.name + "` | yes | " +
         (format.write == nullptr ? "no" : format.written_as) + " | " +
         format.kept + (format.kept.empty() ? "| " : " | ") + format.lost +
         (format.lost.empty() ? "|" : " |");
}

}  // namespace kinegraph
