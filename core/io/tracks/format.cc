#include "core/io/tracks/format.h"

#include <algorithm>
#include <filesystem>

#include "core/base/split.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"
#include "core/io/tracks/person_files.h"

// One line a format, in the order in which they are listed; no other order
// matters, as no two recognise the same. Each names the function that makes the
// format's entry, which its own file defines.
#define KINEGRAPH_TRACK_FORMATS(FORMAT) \
  FORMAT(KinegraphTrackFormat)          \
  FORMAT(CsvTrackFormat)                \
  FORMAT(NpzTrackFormat)                \
  FORMAT(TrcTrackFormat)                \
  FORMAT(C3dTrackFormat)                \
  FORMAT(BvhTrackFormat)                \
  FORMAT(GltfTrackFormat)               \
  FORMAT(MovementTrackFormat)           \
  FORMAT(AniposeTrackFormat)            \
  FORMAT(Coco3dTrackFormat)             \
  FORMAT(FreeMoCapTrackFormat)          \
  FORMAT(PosesTrackFormat)              \
  FORMAT(LongcwTrackFormat)             \
  FORMAT(FourDAssociationTrackFormat)   \
  FORMAT(PanopticTrackFormat)           \
  FORMAT(TumTrackFormat)

namespace kinegraph {

#define KINEGRAPH_DECLARE(make) TrackFormat make();
KINEGRAPH_TRACK_FORMATS(KINEGRAPH_DECLARE)
#undef KINEGRAPH_DECLARE

namespace {

std::string FilesText(const TrackFormat& format) {
  switch (format.files) {
    case TrackFormat::Files::kOne:
      return "file";
    case TrackFormat::Files::kFileAPerson:
      return "folder, a file a person; `NAME" + format.person_extension +
             "`: the file of one person";
    case TrackFormat::Files::kFileAFrame:
      return "folder, a file a frame";
  }
  return "";
}

}  // namespace

const std::vector<TrackFormat>& TrackFormats() {
#define KINEGRAPH_MAKE(make) make(),
  static const std::vector<TrackFormat> kFormats = {
      KINEGRAPH_TRACK_FORMATS(KINEGRAPH_MAKE)};
#undef KINEGRAPH_MAKE
  return kFormats;
}

const TrackFormat* FindTrackFormat(const std::string& name) {
  for (const TrackFormat& format : TrackFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

const TrackFormat* TrackFormatOfExtension(const std::string& path) {
  for (const TrackFormat& format : TrackFormats()) {
    if (format.write == nullptr) continue;
    for (const std::string& extension : format.extensions) {
      if (EndsIn(path, extension)) return &format;
    }
  }
  return nullptr;
}

std::string TrackExtensions() {
  std::vector<std::string> all;
  for (const TrackFormat& format : TrackFormats()) {
    if (format.write == nullptr) continue;
    all.insert(all.end(), format.extensions.begin(), format.extensions.end());
  }
  std::string text;
  for (size_t i = 0; i < all.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == all.size() ? " or " : ", ") + all[i];
  }
  return text;
}

bool TrackHead::HasKey(const std::string& key) const {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

std::vector<std::string> TrackHead::FirstRow() const {
  return FirstCsvRow(beginning);
}

bool TrackHead::HasFile(const std::string& extension) const {
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return EndsIn(name, extension);
  });
}

TrackHead LookAtTracks(const std::string& path) {
  TrackHead head;
  head.is_folder = IsFolder(path);
  if (head.is_folder) {
    for (const std::string& name : ListFolder(path)) {
      if (name.front() != '.') head.names.push_back(name);
    }
    return head;
  }
  const JsonHead json = PeekJson(path);
  head.kind = json.kind;
  head.keys = json.keys;
  head.beginning = BeginningOf(path, 1 << 16);
  return head;
}

const TrackFormat* RecogniseTracks(const TrackHead& head) {
  for (const TrackFormat& format : TrackFormats()) {
    if (format.recognise != nullptr && format.recognise(head)) return &format;
  }
  return nullptr;
}

std::string TableRow(const TrackFormat& format) {
  std::string read = format.read != nullptr ? "yes" : "no";
  if (!format.read_note.empty()) read += ", " + format.read_note;
  return "| `" + format.name + "` | " + read + " | " +
         (format.write == nullptr ? "no" : FilesText(format)) + " | " +
         format.kept + " | " + format.lost + " |";
}

PersonNames ReadPersonNames(const std::string& path) {
  if (IsPipe(path) || (!IsFolder(path) && !IsFile(path))) return {};
  const TrackFormat* format = RecogniseTracks(LookAtTracks(path));
  if (format == nullptr || format->read_names == nullptr) return {};
  return format->read_names(path);
}

}  // namespace kinegraph
