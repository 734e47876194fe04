// Plausibility of tracks in formats that leave something open: their unit and
// the upward axis.
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

// A note if people read from `path` with these options have an impossible size,
// with the unit that corrects it; empty if the size is plausible or the format
// states its unit.
std::string UnitNote(const std::string& path, const TrackReadOptions& options,
                     const TrackSequence& tracks);

// How the people of tracks stand; skeletons that are not human are ignored.
Stance StanceOf(const TrackSequence& tracks);

// "people stand along -y of the world, which trc shows as -X, not along z, ..."
// and the --axes that correct it, empty if none do. nullopt if people stand as
// the format expects, or if it has no upward axis. `axes`: instead of the
// format's.
struct AxesNote {
  std::string text;
  std::string axes;
};
// `stated`: StatedUp of the source of the tracks.
std::optional<AxesNote> FindAxesNote(
    const Stance& stance, const CameraRig& cameras, const TrackFormat& format,
    const std::optional<AxisMap>& axes,
    const std::optional<Eigen::Vector3d>& stated = std::nullopt);

// The world axis that the format shows as up; nullopt if it has none.
std::optional<Eigen::Vector3d> StatedUp(const TrackFormat& format);
// The same for a file; nullopt for a pipe.
std::optional<Eigen::Vector3d> StatedUp(const std::string& path,
                                        const TrackReadOptions& options = {});

// The --axes for which a file, read as `read`, has the world axis `up` along z.
std::string AxesOfReading(const AxisMap& read, const Eigen::Vector3d& up);
// The same for tracks in the world of a reader, whose z is up: for formats with
// axes of their own, if other axes make people stand upright.
std::optional<AxesNote> FindReadingNote(const Stance& stance,
                                        const TrackFormat& format,
                                        const std::optional<AxisMap>& axes);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_READING_NOTES_H_
