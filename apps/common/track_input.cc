#include "apps/common/track_input.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "core/base/error.h"
#include "core/io/tracks/reading_notes.h"

namespace kinegraph {

void PrintUnitNote(const std::string& command, const std::string& path,
                   const TrackReadOptions& options,
                   const TrackSequence& tracks) {
  const std::string note = UnitNote(path, options, tracks);
  if (note.empty()) return;
  std::fprintf(stderr, "kinegraph-%s: note: %s: %s\n", command.c_str(),
               Printable(path).c_str(), note.c_str());
}

TrackInput::TrackInput(std::string command, const std::string& unit_flag,
                       const std::vector<std::string>& paths)
    : command_(std::move(command)) {
  if (unit_flag.empty()) return;
  unit_m_ = ParseLengthUnit(unit_flag);
  if (std::none_of(paths.begin(), paths.end(), [](const std::string& path) {
        return LeavesUnitOpen(path);
      })) {
    throw InputError(
        "--unit belongs to tracks whose format does not tell it, "
        "as BVH; these tell it");
  }
}

TrackSequence TrackInput::Read(const std::string& path,
                               TrackReadOptions options) const {
  if (unit_m_ > 0.0 && LeavesUnitOpen(path)) options.unit_m = unit_m_;
  TrackSequence tracks = ReadTracks(path, options);
  PrintUnitNote(command_, path, options, tracks);
  return tracks;
}

}  // namespace kinegraph
