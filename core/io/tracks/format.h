// The table of formats of 3D tracks. Recognition, `convert --formats`, the
// applicable flags and the choice of a format by the extension in `track --out`
// and `convert --out` are derived from it. A new format requires its functions
// and two entries in format.cc.
#ifndef KINEGRAPH_CORE_IO_TRACKS_FORMAT_H_
#define KINEGRAPH_CORE_IO_TRACKS_FORMAT_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/data/identity_edit.h"
#include "core/data/pose.h"
#include "core/io/text/file_head.h"
#include "core/io/text/lost_fields.h"
#include "core/io/tracks/axis_map.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {

struct TrackExportOptions {
  // The world axes along the file's X, Y, Z, instead of the format's own.
  std::optional<AxisMap> axes;
  PersonNames names;
};

// The beginning of a path's content, to recognise its format.
struct TrackHead : FileHead {
  bool is_folder = false;
  std::vector<std::string> names;  // in the folder, without hidden ones

  bool BeginsWith(std::string_view text) const {
    return beginning.compare(0, text.size(), text) == 0;
  }
  // Whether the folder contains a file of this extension.
  bool HasFile(const std::string& extension) const;
};

struct TrackFormat {
  using Recognise = bool (*)(const TrackHead& head);
  using Read = TrackSequence (*)(const std::string& path,
                                 const TrackReadOptions& options);
  using ReadNames = PersonNames (*)(const std::string& path);
  // Writes a file or a folder, which appears only when it is complete. Throws
  // InputError if it cannot be created or the format cannot represent the
  // tracks. Adds what the format cannot store to `lost_fields`.
  using Write = void (*)(const std::string& path, const TrackSequence& tracks,
                         const TrackExportOptions& options,
                         LostFields* lost_fields);

  std::string name;
  std::string layout;  // one line for users
  // Extensions of --out that select this format; empty if only --to does.
  std::vector<std::string> extensions;
  Recognise recognise = nullptr;
  Read read = nullptr;    // null: write only
  Write write = nullptr;  // null: read only
  // The world axes along the file's X, Y, Z, for formats with axes of their own
  // (--axes replaces them).
  std::optional<AxisMap> axes = std::nullopt;
  // The usual unit of lengths [m], for formats that do not specify it (--unit
  // replaces it).
  std::optional<double> unit_m = std::nullopt;
  bool has_marker_names = false;   // joints may be renamed when writing
  bool keeps_names = false;        // names of people are written
  ReadNames read_names = nullptr;  // reads the names of people in the file
  // Extension of the files in a folder with one file per person; a path with
  // it is the file of one person. Empty for other formats.
  std::string person_extension = "";
  bool is_file_a_frame = false;  // a folder with one file per frame
  // Every file that `recognise` accepts contains tracks.
  bool is_unmistakable = true;
  // kinegraph-adapters recognises and reads it (unless `read` is null) and
  // writes it.
  bool is_of_adapter = false;
};

const std::vector<TrackFormat>& TrackFormats();
// Names of the formats for which `wanted` is true: "csv, npz".
std::string TrackFormatNames(bool (*wanted)(const TrackFormat& format));
// nullptr if there is none of this name.
const TrackFormat* FindTrackFormat(const std::string& name);
// The format to write for the path's extension, or nullptr.
const TrackFormat* TrackFormatOfExtension(const std::string& path);
// The extensions that determine a format: ".jsonl, .csv or .npz".
std::string TrackExtensions();

// Reads the beginning of a path; throws InputError if it cannot be read.
TrackHead LookAtTracks(const std::string& path);
// The first format that recognises `head`, or nullptr.
const TrackFormat* RecogniseTracks(const TrackHead& head);

// The format in the options, otherwise kinegraph's own for a pipe, otherwise
// the one that recognises the path: the program of SetAdapter (adapter.h) is
// asked first, then built-in formats, then other adapters. Throws InputError if
// none recognises the path, and OptionError for a name that is unknown or of a
// format that is only written.
const TrackFormat& FormatOfTracks(const std::string& path,
                                  const TrackReadOptions& options);

// The names of people in kinegraph's JSON Lines ("names" of the header), CSV
// (column `name`), NPZ (array `names`), C3D (SUBJECTS:NAMES) and the names of
// files with one person (person_3_Anna.trc). Empty for other formats, files
// without names, paths that do not exist and pipes, which cannot be read twice.
// Throws InputError for a malformed file.
PersonNames ReadPersonNames(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_FORMAT_H_
