#include "core/io/detections/format.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>

#include "core/base/error.h"
#include "core/io/binary/hdf5_file.h"
#include "core/io/files/folder_entry.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/names.h"

// One line a format, in the order in which they are listed. Each names the
// function that makes the format's entry, which its own file defines.
#define KINEGRAPH_DETECTION_FORMATS(FORMAT) \
  FORMAT(KinegraphDetectionFormat)          \
  FORMAT(CaliscopeFormat)                   \
  FORMAT(OpenPoseFormat)                    \
  FORMAT(CocoResultsFormat)                 \
  FORMAT(CocoViewsFormat)                   \
  FORMAT(MmposeFormat)                      \
  FORMAT(MediaPipeCsvFormat)                \
  FORMAT(DeepLabCutFormat)                  \
  FORMAT(DeepLabCutH5Format)                \
  FORMAT(SleapFormat)                       \
  FORMAT(FreeMoCapFormat)                   \
  FORMAT(LongcwDetectionFormat)             \
  FORMAT(SmapFormat)

namespace kinegraph {

#define KINEGRAPH_DECLARE(make) DetectionFormat make();
KINEGRAPH_DETECTION_FORMATS(KINEGRAPH_DECLARE)
#undef KINEGRAPH_DECLARE

namespace {

namespace fs = std::filesystem;

// With the extension of a format that has several files.
bool IsDataFile(const fs::path& path) {
  const std::string extension = path.extension().string();
  return std::any_of(DetectionFormats().begin(), DetectionFormats().end(),
                     [&](const DetectionFormat& format) {
                       return format.files != DetectionFormat::Files::kOne &&
                              format.extension == extension;
                     });
}

// The first file of data in a folder, in natural order.
std::optional<std::string> FirstFile(const std::string& folder) {
  std::optional<std::string> first;
  for (const std::string& name : ListFolder(folder)) {
    if (name.front() == '.' || !IsDataFile(name)) continue;
    if (!IsFileOrFolder(fs::directory_entry(folder + "/" + name))) continue;
    if (!first || NaturalLess(name, *first)) first = name;
  }
  if (!first) return std::nullopt;
  return folder + "/" + *first;
}

}  // namespace

std::vector<std::string> FoldersIn(const std::string& folder) {
  std::vector<std::string> folders;
  for (const std::string& name : ListFolder(folder)) {
    const std::string inside = folder + "/" + name;
    if (name.front() != '.' && IsFolder(inside)) folders.push_back(inside);
  }
  std::sort(folders.begin(), folders.end(), NaturalLess);
  return folders;
}

const std::vector<DetectionFormat>& DetectionFormats() {
#define KINEGRAPH_MAKE(make) make(),
  static const std::vector<DetectionFormat> kFormats = {
      KINEGRAPH_DETECTION_FORMATS(KINEGRAPH_MAKE)};
#undef KINEGRAPH_MAKE
  return kFormats;
}

const DetectionFormat* FindDetectionFormat(const std::string& name) {
  for (const DetectionFormat& format : DetectionFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

bool DetectionHead::HasKey(const std::string& key) const {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

std::vector<std::string> DetectionHead::FirstRow() const {
  return FirstCsvRow(beginning);
}

DetectionHead LookAtDetections(const std::string& path) {
  DetectionHead head;
  head.path = path;
  head.is_folder = IsFolder(path);
  head.file = path;
  if (head.is_folder) {
    const std::vector<std::string> folders = FoldersIn(path);
    head.has_folders = !folders.empty();
    std::optional<std::string> file = FirstFile(path);
    for (const std::string& folder : folders) {
      if (!file) file = FirstFile(folder);
    }
    head.file = file.value_or("");
    if (head.file.empty()) return head;
  }
  const JsonHead json = PeekJson(head.file);
  head.kind = json.kind;
  head.keys = json.keys;
  head.beginning = BeginningOf(head.file, 1 << 16);
  if (IsHdf5(head.file)) {
    try {
      head.keys = Hdf5Names(head.file);
    } catch (const InputError&) {
      // Beside other files of a folder it may be nobody's.
      if (!head.is_folder) throw;
    }
  }
  return head;
}

bool LeavesOutEmptyFrames(const std::string& path,
                          const DetectionReadOptions& options) {
  const DetectionFormat* format =
      options.format == "auto" ? RecogniseDetections(LookAtDetections(path))
                               : FindDetectionFormat(options.format);
  return format != nullptr && format->leaves_out_empty;
}

const DetectionFormat* RecogniseDetections(const DetectionHead& head) {
  for (const DetectionFormat& format : DetectionFormats()) {
    if (format.recognise != nullptr && format.recognise(head)) return &format;
  }
  return nullptr;
}

}  // namespace kinegraph
