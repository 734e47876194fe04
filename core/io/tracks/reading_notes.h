// What looks wrong in tracks where formats leave something open: their unit,
// and which way is up.
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

// That people who were read from `path` with these options are as tall as
// nobody is, and the unit that mends it; empty where nothing looks wrong or the
// format tells its unit.
std::string UnitNote(const std::string& path, const TrackReadOptions& options,
                     const TrackSequence& tracks);

// How the people of tracks stand; those whose skeleton is not human do not.
Stance StanceOf(const TrackSequence& tracks);

// "people stand along -y of the world, which trc shows as -X, not along z,
// ..." and the --axes that stand them up, empty where none do. Nothing where
// people stand as the format has it, or it has no way up. `axes`: instead of
// the format's.
struct AxesNote {
  std::string text;
  std::string axes;
};
// `stated`: StatedUp of where the tracks are from.
std::optional<AxesNote> FindAxesNote(
    const Stance& stance, const CameraRig& cameras, const TrackFormat& format,
    const std::optional<AxisMap>& axes,
    const std::optional<Eigen::Vector3d>& stated = std::nullopt);

// The world's axis that the format of a file shows as up; nullopt where it has
// none.
std::optional<Eigen::Vector3d> StatedUp(const TrackFormat& format);
// Of a file; nullopt for a pipe too.
std::optional<Eigen::Vector3d> StatedUp(const std::string& path,
                                        const TrackReadOptions& options = {});

// The --axes with which a file that is read as `read` has the world's axis `up`
// along z.
std::string AxesOfReading(const AxisMap& read, const Eigen::Vector3d& up);
// The same of the world that tracks were read into, whose z is up: of a format
// with axes of its own, where other axes of reading stand people up.
std::optional<AxesNote> FindReadingNote(const Stance& stance,
                                        const TrackFormat& format,
                                        const std::optional<AxisMap>& axes);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_READING_NOTES_H_
