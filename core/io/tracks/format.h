// The formats of 3D tracks: one entry each, from which follow recognition,
// `convert --formats`, what its flags belong to, and what `track --out` and
// `convert --out` make of an extension. A format joins by its functions and by
// two lines in format.cc.
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
  // Which world axes the file's X, Y, Z are, instead of the format's own.
  std::optional<AxisMap> axes;
  PersonNames names;
};

// What a path looks like, for recognising its format.
struct TrackHead {
  bool is_folder = false;
  std::vector<std::string> names;  // in the folder, hidden ones left out
  char kind = '\0';                // of a file: first that is no space
  std::vector<std::string> keys;   // outermost keys of a JSON object
  std::string beginning;           // of a file: its first 64 KiB

  bool HasKey(const std::string& key) const;
  std::vector<std::string> FirstRow() const;  // of a table
  bool BeginsWith(const std::string& text) const {
    return beginning.compare(0, text.size(), text) == 0;
  }
  // Whether the folder has a file of that extension.
  bool HasFile(const std::string& extension) const;
};

struct TrackFormat {
  using Recognise = bool (*)(const TrackHead& head);
  using Read = TrackSequence (*)(const std::string& path,
                                 const TrackReadOptions& options);
  using ReadNames = PersonNames (*)(const std::string& path);
  // Writes a file or a folder, which appears when it is complete; numbers read
  // back bit for bit. Throws InputError when it cannot be made or the tracks do
  // not fit the format. What the format leaves out is added to `lost_fields`.
  using Write = void (*)(const std::string& path, const TrackSequence& tracks,
                         const TrackExportOptions& options,
                         LostFields* lost_fields);

  enum class Files {
    kOne,          // the whole recording
    kFileAPerson,  // a folder with a file a person; a path that ends as those
                   // files do is the file of one person
    kFileAFrame,   // a folder with a file a frame
  };

  std::string name;
  std::string layout;  // one line for people
  // Those that choose the format when something is written; none where others
  // have a better claim to them.
  std::vector<std::string> extensions;
  Recognise recognise = nullptr;
  Read read = nullptr;    // null: write only
  Write write = nullptr;  // null: read only
  // The format's own axes, where a file has axes of its own (--axes).
  std::optional<AxisMap> axes = std::nullopt;
  // The usual unit of lengths [m] where files do not tell theirs (--unit).
  std::optional<double> unit_m = std::nullopt;
  bool has_marker_names = false;   // joints may be written under other names
  bool keeps_names = false;        // what is written holds names of people
  ReadNames read_names = nullptr;  // of people, where they are in the file
  Files files = Files::kOne;
  std::string person_extension = "";  // of a file a person
  // Whatever it recognises is of no other kind than tracks.
  bool is_unmistakable = true;
  // kinegraph-adapters recognises, reads and writes it.
  bool is_of_adapter = false;
};

const std::vector<TrackFormat>& TrackFormats();
// Names of those that have what `wanted` says: "csv, npz".
std::string TrackFormatNames(bool (*wanted)(const TrackFormat& format));
// nullptr when there is none of that name.
const TrackFormat* FindTrackFormat(const std::string& name);
// The format that the end of the path chooses for writing, or nullptr.
const TrackFormat* TrackFormatOfExtension(const std::string& path);
// Extensions that choose a format: ".jsonl, .csv or .npz".
std::string TrackExtensions();

// Looks at a path; throws InputError when it cannot be read.
TrackHead LookAtTracks(const std::string& path);
// The format that recognises it, or nullptr.
const TrackFormat* RecogniseTracks(const TrackHead& head);

// The option's format, else the one that recognises the path; throws as
// ReadTracks.
const TrackFormat& FormatOfTracks(const std::string& path,
                                  const TrackReadOptions& options);

// The names that are kept in our JSON Lines ("names" of the header), CSV
// (column `name`), NPZ (array `names`) and TRC (person_3_Anna.trc); none for
// other formats, for files without names and for pipes, which cannot be read
// twice. Throws InputError when names are there and no names.
PersonNames ReadPersonNames(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_FORMAT_H_
