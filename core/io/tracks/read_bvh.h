// BVH of tracks: what its reader and its writer share. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_READ_BVH_H_
#define KINEGRAPH_CORE_IO_TRACKS_READ_BVH_H_

#include <string>

#include "core/io/tracks/axis_map.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {

inline constexpr const char* kBvhExtension = ".bvh";
inline constexpr double kBvhCentimetre_m = 0.01;

// x, z up, -y: Blender, which turns Y up into Z up, then shows our world.
inline AxisMap BvhAxes() { return AxisMap::Parse("x,z,-y"); }

TrackSequence ReadTracksBvh(const std::string& path,
                            const TrackReadOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_READ_BVH_H_
