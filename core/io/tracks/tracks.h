// Reading 3D results and ground truth in all supported formats.
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

// Meaning of a joint stored as zeros (weight 0) in 4D association's files.
enum class StoredZeros {
  kMissing,
  kKeep,  // a position, as in 4D association's own evaluation
};

struct TrackReadOptions {
  // Name of a format (format.h); empty: recognised by content.
  std::string format;
  // For files that do not specify their skeleton, or only by a number of joints
  // that several skeletons have. With 4da19, "joints19" of a {"poses"} file is
  // read.
  std::optional<Skeleton> skeleton;
  // Overrides the file's rate. 0: not given; then 29.97 for Panoptic and 25
  // for longcw (whose frame numbers are round(rate * timestamp)).
  double frame_rate_hz = 0.0;
  // Throws InputError if the file states a rate that differs from frame_rate_hz
  // by more than 1 %.
  bool refuse_other_rate = false;
  // Frame of the first entry of 4D association's files: Shelf's test set begins
  // at 300.
  int64_t first_frame = 300;
  StoredZeros stored_zeros = StoredZeros::kMissing;
  // The world axes along the file's X, Y, Z, for formats with axes of their own
  // (TRC); nullopt: the format's.
  std::optional<AxisMap> axes;
  // Unit of the file's lengths [m], for formats that do not specify it (BVH);
  // 0: the format's usual unit.
  double unit_m = 0.0;
};

// Units of length in files [m].
inline constexpr std::pair<const char*, double> kLengthUnits[] = {
    {"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}};
// Length of "m", "cm" or "mm" [m]; throws InputError naming `flag`.
double ParseLengthUnit(const std::string& text,
                       const std::string& flag = "--unit");
// Whether the format of the path does not specify its unit. Throws like
// FormatOfTracks.
bool LeavesUnitOpen(const std::string& path);

// Reads all frames. Throws InputError naming the file, OptionError for invalid
// options. Frames without people are kept. Positions are kObserved unless the
// format specifies a status or, as Panoptic's, a low confidence. Ids are those
// in the file or in its name; if it has none, or if longcw's reach 2^31, they
// are 0, 1, 2 in order of appearance. header.mode names the format unless the
// file specifies it. Times are those in the file, otherwise frame / frame rate,
// or 0 if the rate is unknown.
TrackSequence ReadTracks(const std::string& path,
                         const TrackReadOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_TRACKS_H_
