// Plausibility of tracks in formats that do not specify their unit or their
// upward axis.
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
// plausible or the format specifies its unit.
std::string UnitNote(const std::string& path, const TrackReadOptions& options,
                     const TrackSequence& tracks);

// How the people of tracks stand; skeletons that are not human are ignored.
Stance StanceOf(const TrackSequence& tracks);

// The note "people stand along -y of the world, not along z, which trc shows as
// up", and the --axes that correct this; empty if none do.
struct AxesNote {
  std::string text;
  std::string axes;
};
// nullopt if people stand as the format expects, or if it has no upward axis.
// `axes`: replaces the format's axes. `stated`: StatedUp of the source of the
// tracks.
std::optional<AxesNote> FindAxesNote(
    const Stance& stance, const CameraRig& cameras, const TrackFormat& format,
    const std::optional<AxisMap>& axes,
    const std::optional<Eigen::Vector3d>& stated = std::nullopt);

// The world axis that is up in tracks read from the format; nullopt if the
// format has no upward axis.
std::optional<Eigen::Vector3d> StatedUp(const TrackFormat& format);
// The same for a file; nullopt for a pipe.
std::optional<Eigen::Vector3d> StatedUp(const std::string& path);

// The --axes that map the world axis `up`, of a file read with the axes `read`,
// to z.
std::string AxesOfReading(const AxisMap& read, const Eigen::Vector3d& up);
// A note on tracks read from a format with axes of its own, if other --axes
// make people stand along z.
std::optional<AxesNote> FindReadingNote(const Stance& stance,
                                        const TrackFormat& format,
                                        const std::optional<AxisMap>& axes);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_READING_NOTES_H_
