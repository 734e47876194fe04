// C3D of tracks, written and read. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_READ_C3D_H_
#define KINEGRAPH_CORE_IO_TRACKS_READ_C3D_H_

#include <string>

#include "core/io/tracks/format.h"

namespace kinegraph {

inline constexpr const char* kC3dExtension = ".c3d";

// Those of laboratories: Z is up.
inline AxisMap C3dAxes() { return AxisMap::Parse("x,y,z"); }

void WriteTracksC3d(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_READ_C3D_H_
