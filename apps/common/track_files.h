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
// .jsonl and .json are our own format, written as frames become final; others
// (core/io/tracks/format.h) keep the recording until its end. Formats with one
// file per person, such as .trc, create a folder of that name without the
// extension.
class TrackOutput {
 public:
  // Throws as CheckTrackOutput and AtomicFiles. `observations` as in
  // TrackWriteOptions. `markers` names the joints in formats that have marker
  // names; others keep ours. Finish() estimates the vertical from `cameras` and
  // people, and reports if that of the format (or of `axes`) differs.
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
  std::optional<TrackWriter> writer_;  // of our own format
  // The members below serve other formats, written from the whole recording.
  const TrackFormat* format_ = nullptr;
  TrackExportOptions options_;
  MarkerNames markers_;
  CameraRig cameras_;
  TrackSequence tracks_;
};

// Throws InputError before any work is done: naming --out and the extensions
// for an unknown one, --markers if the format has no marker names, --axes if it
// has no axes.
void CheckTrackOutput(const std::string& path, MarkerNames markers,
                      const std::optional<AxisMap>& axes);

// "out/take" for "out/take.trc".
std::string WithoutExtension(const std::string& path);

// The value of --markers. Throws InputError listing the allowed ones.
MarkerNames MarkersFlag(const std::string& text);

// Reports on stderr that people have no plausible height, and which --unit
// corrects it, if the format leaves its unit open.
void PrintUnitNote(const std::string& command, const std::string& path,
                   const TrackReadOptions& options,
                   const TrackSequence& tracks);

// Reads tracks of several files; --unit applies to those whose format leaves it
// open. Throws InputError if it is given but no format does.
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

// Prints notes on standard error that do not stop a command, each line prefixed
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
