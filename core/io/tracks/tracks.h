// Reading 3D results and ground truth in every format there is.
#ifndef KINEGRAPH_CORE_IO_TRACKS_TRACKS_H_
#define KINEGRAPH_CORE_IO_TRACKS_TRACKS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "core/data/pose.h"
#include "core/io/tracks/axis_map.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// What a joint stored as zeros (weight 0) is, in 4D association's files.
enum class StoredZeros {
  kMissing,
  kKeep,  // a position: 4D association's own evaluation takes it as it stands
};

struct TrackReadOptions {
  // Name of a format (format.h); empty: by content.
  std::string format;
  // Of formats that do not tell their skeleton, where the number of joints is
  // not enough. With 4da19 a {"poses"} file is asked for its "joints19".
  std::optional<Skeleton> skeleton;
  // Wins over the file's. 0: as the file tells; 25 for longcw, whose frame
  // numbers are round(25 timestamp).
  double frame_rate_hz = 0.0;
  // Frame of the first entry of 4D association's files: Shelf's test begins
  // at 300.
  int64_t first_frame = 300;
  StoredZeros stored_zeros = StoredZeros::kMissing;
  // Which world axes the file's X, Y, Z are, in formats with axes of their own
  // (TRC); else the format's.
  std::optional<AxisMap> axes;
  // Length of the file's unit [m], in formats that do not tell it (BVH); 0: the
  // format's usual one.
  double unit_m = 0.0;
};

// The units of length that files have [m].
inline constexpr std::pair<const char*, double> kLengthUnits[] = {
    {"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}};
// Length of "m", "cm" or "mm" [m]; throws InputError naming `flag`.
double ParseLengthUnit(const std::string& text,
                       const std::string& flag = "--unit");
// Whether the format at the path leaves its unit open. Throws as ReadTracks.
bool LeavesUnitOpen(const std::string& path,
                    const TrackReadOptions& options = {});

// All frames. Throws InputError naming the file. Frames that the file has are
// there even when they have no people (TUM: all 3200). What a file gives as a
// position is kObserved; in our own format the status is the file's. Ids are
// the file's; those of longcw may be beyond every integer type and then count
// 0, 1, 2 in order of appearance. header.mode names the format. Times are those
// of the file, else frame / frame rate, else 0.
TrackSequence ReadTracks(const std::string& path,
                         const TrackReadOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_TRACKS_H_
