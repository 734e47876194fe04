// Reading and writing of tracks by commands, and the stream of their summary.
#ifndef KINEGRAPH_APPS_COMMON_TRACK_FILES_H_
#define KINEGRAPH_APPS_COMMON_TRACK_FILES_H_

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/data/identity_edit.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/joint_names.h"
#include "core/io/tracks/axis_map.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"

namespace kinegraph {

// The output of `track`: the extension of --out selects the format.
//
// .jsonl, .json and streams select kinegraph's own format, which is written as
// frames become final; for others (core/io/tracks/format.h) the recording is
// kept in memory until its end. Formats with one file per person, such as .trc,
// or per frame create a folder of that name without the extension.
class TrackOutput {
 public:
  // Throws what CheckTrackOutput and AtomicFiles throw. `observations`: see
  // TrackWriteOptions. `markers` names the joints in formats that have marker
  // names; others keep kinegraph's names. Finish() estimates the vertical from
  // `cameras` and people, and prints a note if it differs by more than 50
  // degrees from the vertical of the format (or of `axes`).
  TrackOutput(const std::string& path, const TrackHeader& header,
              bool observations, const PersonNames& names, MarkerNames markers,
              const CameraRig& cameras, const std::optional<AxisMap>& axes);

  void Write(TrackFrame&& frame);
  // Flushes written frames, for the reader of a stream.
  void Flush();
  // Completes the result under its temporary name; side files can be added
  // then.
  void Finish();
  AtomicFiles& files() { return files_; }
  // After Finish(): makes the result and its side files appear.
  void Commit() { files_.Commit(); }
  // The file or folder that will appear.
  const std::string& path() const { return path_; }

 private:
  AtomicFiles files_;
  std::string path_;
  std::optional<TrackWriter> writer_;  // of kinegraph's own format
  // The members below serve other formats, written from the whole recording.
  const TrackFormat* format_ = nullptr;
  const bool observations_;
  TrackExportOptions options_;
  MarkerNames markers_;
  CameraRig cameras_;
  TrackSequence tracks_;
};

// Throws InputError before any work is done: for an unknown extension, for
// --markers with a format without marker names, and for --axes with a format
// without axes.
void CheckTrackOutput(const std::string& path, MarkerNames markers,
                      const std::optional<AxisMap>& axes);

// "out/take" for "out/take.trc".
std::string WithoutExtension(const std::string& path);

// The value of --markers. Throws InputError that lists the allowed values.
MarkerNames MarkersFlag(const std::string& text);

// If the format does not specify its unit and people have implausible sizes,
// prints a note on stderr that suggests a --unit.
void PrintUnitNote(const std::string& command, const std::string& path,
                   const TrackReadOptions& options,
                   const TrackSequence& tracks);

// Reads tracks of several files; --unit applies to the files whose format does
// not specify the unit. Throws InputError if --unit is given and all specify
// it.
class TrackInput {
 public:
  TrackInput(std::string command, const std::string& unit_flag,
             const std::vector<std::string>& paths);
  TrackSequence Read(const std::string& path,
                     const TrackReadOptions& options = {}) const;
  // `options` with --unit if it applies to that file.
  TrackReadOptions OptionsFor(const std::string& path,
                              TrackReadOptions options) const;

 private:
  std::string command_;
  double unit_m_ = 0.0;
};

// Standard output, or standard error if the result `out` itself goes to
// standard output (--out=/dev/stdout).
inline std::FILE* SummaryStream(const std::string& out) {
  return IsStandardOutput(out) ? stderr : stdout;
}

// Prints notes, which do not stop a command, on standard error, each prefixed
// with `program`.
inline void SayNotes(const std::vector<std::string>& notes,
                     const std::string& program = "") {
  for (const std::string& note : notes) {
    std::fprintf(stderr, "%snote: %s\n", program.c_str(),
                 Printable(note, 500).c_str());
  }
}

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TRACK_FILES_H_
