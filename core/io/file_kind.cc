#include "core/io/file_kind.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <vector>

#include "core/base/error.h"
#include "core/io/adapters/adapter.h"
#include "core/io/calibration/format.h"
#include "core/io/detections/format.h"
#include "core/io/files/text_file.h"
#include "core/io/text/file_head.h"
#include "core/io/text/words.h"
#include "core/io/tracks/format.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

FileKind KindBy(const Adapter& adapter) {
  switch (adapter.kind) {
    case AdapterKind::kCameras:
      return FileKind::kCalibration;
    case AdapterKind::kDetections:
      return FileKind::kDetections;
    default:
      return FileKind::kTracks;
  }
}

// For paths that no built-in format recognises: asks the adapters.
FileKind KindByAdapter(const std::string& path) {
  if (const auto adapter = AdapterOf(path)) return KindBy(*adapter);
  throw InputError(
      path, "",
      "is not a calibration, detections or tracks in a known format "
      "(specify the format by --from)");
}

bool AreSurelyTracks(const std::string& path) {
  const TrackFormat* format = RecogniseTracks(LookAtTracks(path));
  return format != nullptr && format->is_unmistakable;
}

bool HasExtension(const std::string& path,
                  const std::vector<std::string>& extensions) {
  const std::string own = fs::path(path).extension().string();
  return std::find(extensions.begin(), extensions.end(), own) !=
         extensions.end();
}

std::string Beginning(const std::string& path) {
  return BeginningOf(path, 1 << 16);
}

// COCO's results contain "image_id", MMPose's predictions "instances" or
// "keypoint_scores"; other arrays are 3D poses in the format of longcw's
// crossview data (core/io/text/longcw.h).
FileKind KindOfArray(const std::string& path) {
  const std::string text = Beginning(path);
  for (const char* key :
       {"\"image_id\"", "\"instances\"", "\"keypoint_scores\""}) {
    if (text.find(key) != std::string::npos) return FileKind::kDetections;
  }
  return FileKind::kTracks;
}

FileKind KindOfObject(const FileHead& head) {
  for (const char* key : {"kinegraph_detections", "people", "3d_pairs",
                          "instance_info", "images", "annotations"}) {
    if (head.HasKey(key)) return FileKind::kDetections;
  }
  if (head.HasKey("frames") && head.HasKey("image_wh")) {
    return FileKind::kDetections;
  }
  return FileKind::kCalibration;  // keys may be arbitrary names of cameras
}

// A projection matrix has 12 numbers. A file of 4D association that contains
// people has at least 64: three counts, an id and fifteen joints of four each.
FileKind KindOfNumbers(const std::string& path) {
  const std::string text = Beginning(path);
  Words words(text, WordBreak::kSpaceOrCommas);
  int count = 0;
  while (!words.Next().empty()) ++count;
  return count == 12 ? FileKind::kCalibration : FileKind::kTracks;
}

// Whether the text begins with a comment, a directive or a table's name in
// brackets. The JSON arrays of supported formats begin with "[{" or are empty.
bool LooksLikeTomlOrYaml(const std::string& text) {
  constexpr const char* kSpaces = " \t\r\n";
  const size_t first = text.find_first_not_of(kSpaces);
  if (first == std::string::npos) return false;
  if (text[first] == '#' || text[first] == '%') return true;
  if (text[first] != '[') return false;
  const size_t second = text.find_first_not_of(kSpaces, first + 1);
  return second != std::string::npos && text[second] != '{' &&
         text[second] != ']';
}

// Tables of keypoints begin with a letter or a quotation mark. Detections in
// JSON are recognised by KindOfObject and KindOfArray.
bool IsDetectionTable(const std::string& path) {
  const std::string text = Beginning(path);
  if (text.empty()) return false;
  const bool is_letter = std::isalpha(static_cast<unsigned char>(text[0])) != 0;
  if (!is_letter && text[0] != '"') return false;
  return RecogniseDetections(LookAtDetections(path)) != nullptr;
}

// Whether the file is a calibration of bioCV or of a motion capture system, by
// its extension or, for XML, its first character.
bool IsOfLaboratory(const std::string& path) {
  if (HasExtension(path, {".calib", ".mcal", ".xcp"})) return true;
  const std::string text = BeginningOf(path, 16);
  const size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string::npos && text[first] == '<';
}

// The first 200 bytes, without a word that is cut off.
std::string FirstWords(const std::string& path) {
  constexpr size_t kMost = 200;
  const std::string text = Beginning(path);
  if (text.size() <= kMost) return text;
  return text.substr(0, text.find_last_of(" \t\r\n,", kMost));
}

FileKind KindOfFile(const std::string& path) {
  if (IsOfLaboratory(path)) return FileKind::kCalibration;
  if (AreSurelyTracks(path)) return FileKind::kTracks;
  if (IsDetectionTable(path)) return FileKind::kDetections;
  if (HasExtension(path, {".toml", ".yml", ".yaml"}) ||
      LooksLikeTomlOrYaml(Beginning(path))) {
    return FileKind::kCalibration;
  }
  const FileHead head = LookAtFile(path);
  if (head.kind == '{') return KindOfObject(head);
  if (head.kind == '[') return KindOfArray(path);
  if (IsNumberTable(FirstWords(path))) return KindOfNumbers(path);
  return KindByAdapter(path);
}

FileKind KindOfFolder(const std::string& path) {
  if (AreSurelyTracks(path)) return FileKind::kTracks;
  if (IsCalibrationFolder(path)) return FileKind::kCalibration;
  if (RecogniseDetections(LookAtDetections(path)) != nullptr) {
    return FileKind::kDetections;
  }
  if (const auto adapter = AdapterOf(path)) return KindBy(*adapter);
  const std::vector<std::string> names = ListFolder(path);
  for (const std::string& name : names) {
    const std::string inside = path + "/" + name;
    if (name.front() == '.') continue;
    if (IsFolder(inside)) return FileKind::kDetections;  // a folder per view
    if (HasExtension(name, {".csv", ".h5"})) return KindOfFile(inside);
    if (!HasExtension(name, {".json"})) continue;
    // In a folder, only detections are stored as arrays; an empty one (COCO's)
    // lacks the keys by which KindOfArray recognises them.
    return LookAtFile(inside).kind == '[' ? FileKind::kDetections
                                          : KindOfFile(inside);
  }
  return KindByAdapter(path);
}

}  // namespace

const char* ToString(FileKind kind) {
  switch (kind) {
    case FileKind::kCalibration:
      return "calibrations";
    case FileKind::kDetections:
      return "detections";
    case FileKind::kTracks:
      return "tracks";
  }
  return "";
}

FileKind RecogniseKind(const std::string& path) {
  if (const auto given = GivenAdapterOf(path)) return KindBy(*given);
  return IsFolder(path) ? KindOfFolder(path) : KindOfFile(path);
}

}  // namespace kinegraph
