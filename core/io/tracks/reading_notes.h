// Plausibility of tracks: the size of people in formats that do not specify the
// unit, and whether people stand along the axis that a format shows as up.
#ifndef KINEGRAPH_CORE_IO_TRACKS_READING_NOTES_H_
#define KINEGRAPH_CORE_IO_TRACKS_READING_NOTES_H_

#include <optional>
#include <string>

#include "core/data/pose.h"
#include "core/data/stance.h"
#include "core/geometry/camera.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {

// A note if people read from `path` with these options have an implausible
// size, with the units for which it is plausible; empty if the size is
// plausible, the format specifies its unit, or there are no people or they are
// not human.
std::string UnitNote(const std::string& path, const TrackReadOptions& options,
                     const TrackSequence& tracks);

// How the people of tracks stand; skeletons that are not human are ignored.
Stance StanceOf(const TrackSequence& tracks);

struct AxesNote {
  // "people stand along -y of the world, not along z, which trc shows as up".
  std::string text;
  // The --axes with which people stand upright; empty if there are none.
  std::string axes;
};
// A note for tracks to be written to `format`; nullopt if people stand within
// 50 degrees of its upward axis (Stance::UpUnlike), if the vertical is unknown
// or if the format has no axes. `axes` replace the format's axes.
// `cameras` (may be empty) and `stated`, the StatedUp of the file from which
// the tracks were read, are further evidence on the vertical.
std::optional<AxesNote> FindAxesNote(
    const Stance& stance, const CameraRig& cameras, const TrackFormat& format,
    const std::optional<AxisMap>& axes,
    const std::optional<Eigen::Vector3d>& stated = std::nullopt);

// Unit vector: the world axis that is up in tracks read from the format;
// nullopt if the format has no upward axis.
std::optional<Eigen::Vector3d> StatedUp(const TrackFormat& format);
// The same for the format that recognises the path; nullopt for a pipe.
std::optional<Eigen::Vector3d> StatedUp(const std::string& path);

// If a file was read with the axes `read` and people stand along the signed
// world axis `up`: the --axes with which reading it again makes them stand
// along z.
std::string AxesOfReading(const AxisMap& read, const Eigen::Vector3d& up);
// A note on tracks read from `format`, which must have axes of its own, with
// `axes` (nullopt: the format's); nullopt unless people stand within 40 degrees
// of a signed axis of the world other than z.
std::optional<AxesNote> FindReadingNote(const Stance& stance,
                                        const TrackFormat& format,
                                        const std::optional<AxisMap>& axes);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_READING_NOTES_H_
