// Force plates of a C3D file: its FORCE_PLATFORM group and analog samples.
#ifndef KINEGRAPH_CORE_IO_TRACKS_FORCE_PLATES_H_
#define KINEGRAPH_CORE_IO_TRACKS_FORCE_PLATES_H_

#include <string>
#include <vector>

#include "core/data/force_plate.h"

namespace kinegraph {

// Of types 1 to 4 (c3d.org's user guide); types that are not known are left
// out. The world's axes are those in which ReadTracks() gives the points.
// Throws InputError naming the file where it has no plates or their channels
// are not there.
std::vector<ForcePlate> ReadForcePlates(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_FORCE_PLATES_H_
