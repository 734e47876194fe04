// Content of a C3D file other than tracks: poses of body segments (its ROTATION
// group, which Theia3D, Visual3D and others write) and force plates (its
// FORCE_PLATFORM group and analog samples).
#ifndef KINEGRAPH_CORE_IO_TRACKS_C3D_H_
#define KINEGRAPH_CORE_IO_TRACKS_C3D_H_

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/data/force_plate.h"
#include "core/io/tracks/axis_map.h"

namespace kinegraph {

struct SegmentFrame {
  int64_t frame = 0;  // from 0, whereas C3D counts from 1
  // One per segment, in metres; nullopt if missing.
  std::vector<std::optional<Eigen::Isometry3d>> world_from_segment;
};

struct SegmentSequence {
  std::vector<std::string> names;  // as in the file, without "_4X4"
  double frame_rate_hz = 0.0;      // 0: unknown
  std::vector<SegmentFrame> frames;
};

// Reads the segments of a C3D file, including the segment of the laboratory
// ("worldbody"); no frames if the file has only points. For files without
// points, ReadTracks() returns the origins of segments as joints. `axes`: see
// TrackReadOptions. Throws InputError naming the file.
SegmentSequence ReadSegments(const std::string& path,
                             const std::optional<AxisMap>& axes = {});

// Reads force plates of types 1 to 4 (c3d.org's user guide); other types are
// ignored. Positions are in the world as ReadTracks() returns it without
// TrackReadOptions::axes; the unit of the channels must be the newton. Throws
// InputError naming the file if it has no such plates, lacks their channels or
// does not specify its frame rate.
std::vector<ForcePlate> ReadForcePlates(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_C3D_H_
