// Writing 3D tracks in formats of other programs.
#ifndef KINEGRAPH_CORE_IO_TRACKS_EXPORT_H_
#define KINEGRAPH_CORE_IO_TRACKS_EXPORT_H_

#include <optional>
#include <string>

#include "core/data/person_names.h"
#include "core/data/pose.h"
#include "core/io/text/lost_fields.h"
#include "core/io/tracks/axis_map.h"

namespace kinegraph {

struct TrackExportOptions {
  // Which world axes the file's X, Y, Z are, instead of the format's own.
  std::optional<AxisMap> axes;
  PersonNames names;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_EXPORT_H_
