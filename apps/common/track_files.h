// Tracks as commands read and write them, and where they say what they have
// done.
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

// Where `track` writes its result: the extension of --out chooses the format.
//
// .jsonl and .json are our own format, written as frames become final; others
// (core/io/tracks/format.h) hold the recording until its end. Formats with a
// file a person, such as .trc, make a folder of that name without the
// extension.
class TrackOutput {
 public:
  // Throws as CheckTrackOutput and AtomicFiles. `observations` as
  // TrackWriteOptions has it. `markers` names the joints of formats that have
  // names of markers; others keep ours. `cameras` tell, beside people, which
  // way is up: Finish() says when a format with a way up shows another, by its
  // own axes or `axes`.
  TrackOutput(const std::string& path, const TrackHeader& header,
              bool observations, const PersonNames& names, MarkerNames markers,
              const CameraRig& cameras, const std::optional<AxisMap>& axes);

  void Write(TrackFrame&& frame);
  // Hands what was written to whoever reads a stream.
  void Flush();
  // Completes the result, aside; files beside it can then be put there, too.
  void Finish();
  AtomicFiles& files() { return files_; }
  // After Finish(): makes the result appear, with what is beside it.
  void Commit() { files_.Commit(); }
  // File or folder that appears.
  const std::string& path() const { return path_; }

 private:
  AtomicFiles files_;
  std::string path_;
  std::optional<TrackWriter> writer_;  // of our own format
  // Of another one, which gets the whole recording.
  const TrackFormat* format_ = nullptr;
  TrackExportOptions options_;
  MarkerNames markers_;
  CameraRig cameras_;
  TrackSequence tracks_;
};

// Throws InputError, before any work is done: naming --out and the extensions
// for an unknown one, --markers where the format has no names of markers,
// --axes where it has no axes.
void CheckTrackOutput(const std::string& path, MarkerNames markers,
                      const std::optional<AxisMap>& axes);

// "out/take" of "out/take.trc".
std::string WithoutExtension(const std::string& path);

// The value of --markers. Throws InputError listing those that there are.
MarkerNames MarkersFlag(const std::string& text);

// Says on stderr that people are as tall as nobody is, and which --unit mends
// it, where the format leaves its unit open.
void PrintUnitNote(const std::string& command, const std::string& path,
                   const TrackReadOptions& options,
                   const TrackSequence& tracks);

// Reads tracks of several files; --unit holds for those whose format leaves it
// open. Throws InputError where it is given and all tell theirs.
class TrackInput {
 public:
  TrackInput(std::string command, const std::string& unit_flag,
             const std::vector<std::string>& paths);
  TrackSequence Read(const std::string& path,
                     const TrackReadOptions& options = {}) const;
  // `options` with --unit, where it holds for that file.
  TrackReadOptions OptionsFor(const std::string& path,
                              TrackReadOptions options) const;

 private:
  std::string command_;
  double unit_m_ = 0.0;
};

// Standard output, or standard error when the result `out` itself goes to
// standard output (--out=/dev/stdout).
inline std::FILE* SummaryStream(const std::string& out) {
  return IsStandardOutput(out) ? stderr : stdout;
}

// What does not keep a command from its work, on standard error; `program`
// stands before each line.
inline void SayNotes(const std::vector<std::string>& notes,
                     const std::string& program = "") {
  for (const std::string& note : notes) {
    std::fprintf(stderr, "%snote: %s\n", program.c_str(),
                 Printable(note, 500).c_str());
  }
}

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TRACK_FILES_H_
