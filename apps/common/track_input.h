// Tracks as commands read them.
#ifndef KINEGRAPH_APPS_COMMON_TRACK_INPUT_H_
#define KINEGRAPH_APPS_COMMON_TRACK_INPUT_H_

#include <string>
#include <vector>

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

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TRACK_INPUT_H_
