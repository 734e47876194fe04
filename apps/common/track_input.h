// Tracks as commands read them, and where they say what they have done.
#ifndef KINEGRAPH_APPS_COMMON_TRACK_INPUT_H_
#define KINEGRAPH_APPS_COMMON_TRACK_INPUT_H_

#include <cstdio>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {

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
                     TrackReadOptions options = {}) const;

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

#endif  // KINEGRAPH_APPS_COMMON_TRACK_INPUT_H_
