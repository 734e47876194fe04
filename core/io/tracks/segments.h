// Poses of body segments, where a file has them: C3D's ROTATION group, which
// Theia3D, Visual3D and others write.
#ifndef KINEGRAPH_CORE_IO_TRACKS_SEGMENTS_H_
#define KINEGRAPH_CORE_IO_TRACKS_SEGMENTS_H_

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_SEGMENTS_H_
