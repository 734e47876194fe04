// What a C3D file has besides tracks: poses of body segments (its ROTATION
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
  int64_t frame = 0;
  // One a segment, metres; nullopt where it is missing.
  std::vector<std::optional<Eigen::Isometry3d>> world_from_segment;
};

struct SegmentSequence {
  std::vector<std::string> names;  // as the program's, without "_4X4"
  double frame_rate_hz = 0.0;      // 0: not known
  std::vector<SegmentFrame> frames;
};

// The segments of a C3D file, those of the laboratory ("worldbody") too; none
// where the file has points alone. The origins are what ReadTracks() gives as
// joints where a file has no points. `axes` as in TrackReadOptions. Throws
// InputError naming the file.
SegmentSequence ReadSegments(const std::string& path,
                             const std::optional<AxisMap>& axes = {});

// Of types 1 to 4 (c3d.org's user guide); types that are not known are left
// out. The world's axes are those in which ReadTracks() gives the points.
// Throws InputError naming the file where it has no plates or their channels
// are not there.
std::vector<ForcePlate> ReadForcePlates(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_C3D_H_
