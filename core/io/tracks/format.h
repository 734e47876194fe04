// The formats of 3D tracks, one entry each. Recognition, `convert --formats`,
// the applicable flags and the format by an extension for `track --out` and
// `convert --out` follow from it. A new format requires its functions and two
// lines in format.cc.
#ifndef KINEGRAPH_CORE_IO_TRACKS_FORMAT_H_
#define KINEGRAPH_CORE_IO_TRACKS_FORMAT_H_

#include <optional>
#include <string>
#include <vector>

#include "core/data/identity_edit.h"
#include "core/data/pose.h"
#include "core/io/text/lost_fields.h"
#include "core/io/tracks/axis_map.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {

struct TrackExportOptions {
  // The world axes that the file's X, Y, Z are, instead of the format's own.
  std::optional<AxisMap> axes;
  PersonNames names;
};

// The beginning of a path's content, to recognise its format.
struct TrackHead {
  bool is_folder = false;
  std::vector<std::string> names;  // in the folder, without hidden ones
  char kind = '\0';                // of a file: its first non-space
  std::vector<std::string> keys;   // keys of the root of a JSON object
  std::string beginning;           // of a file: its first 64 KiB

  bool HasKey(const std::string& key) const;
  std::vector<std::string> FirstRow() const;  // of a table
  bool BeginsWith(const std::string& text) const {
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
  // Writes a file or a folder, which appears when complete; numbers read back
  // bit by bit. Throws InputError if it cannot be created or the format cannot
  // represent the tracks. Omissions of the format are added to `lost_fields`.
  using Write = void (*)(const std::string& path, const TrackSequence& tracks,
                         const TrackExportOptions& options,
                         LostFields* lost_fields);

  enum class Files {
    kOne,          // the whole recording
    kFileAPerson,  // a folder with one file per person; a path with the
                   // extension of these files is the file of one person
    kFileAFrame,   // a folder with one file per frame
  };

  std::string name;
  std::string layout;  // one line for users
  // Extensions that choose the format for writing; empty if other formats take
  // precedence.
  std::vector<std::string> extensions;
  Recognise recognise = nullptr;
  Read read = nullptr;    // null: write only
  Write write = nullptr;  // null: read only
  // The format's own axes, for formats with axes of their own (--axes).
  std::optional<AxisMap> axes = std::nullopt;
  // The usual unit of lengths [m] of formats that do not state it (--unit).
  std::optional<double> unit_m = std::nullopt;
  bool has_marker_names = false;   // joints may be renamed when writing
  bool keeps_names = false;        // the file contains names of people
  ReadNames read_names = nullptr;  // of people, if they are in the file
  Files files = Files::kOne;
  std::string person_extension = "";  // for one file per person
  // All files that it recognises are tracks.
  bool is_unmistakable = true;
  // kinegraph-adapters recognises, reads and writes it.
  bool is_of_adapter = false;
};

const std::vector<TrackFormat>& TrackFormats();
// Names of the formats for which `wanted` is true: "csv, npz".
std::string TrackFormatNames(bool (*wanted)(const TrackFormat& format));
// nullptr if there is none of this name.
const TrackFormat* FindTrackFormat(const std::string& name);
// The format that the path's extension chooses for writing, or nullptr.
const TrackFormat* TrackFormatOfExtension(const std::string& path);
// Extensions that choose a format: ".jsonl, .csv or .npz".
std::string TrackExtensions();

// Reads the beginning of a path; throws InputError if it cannot be read.
TrackHead LookAtTracks(const std::string& path);
// The format that recognises it, or nullptr.
const TrackFormat* RecogniseTracks(const TrackHead& head);

// The option's format, else the one that recognises the path; throws as
// ReadTracks does.
const TrackFormat& FormatOfTracks(const std::string& path,
                                  const TrackReadOptions& options);

// The names of people in our JSON Lines ("names" of the header), CSV (column
// `name`), NPZ (array `names`) and TRC (person_3_Anna.trc); empty for other
// formats, files without names and pipes, which cannot be read twice. Throws
// InputError if they are malformed.
PersonNames ReadPersonNames(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_FORMAT_H_
