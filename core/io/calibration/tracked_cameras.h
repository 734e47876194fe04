#ifndef KINEGRAPH_CORE_IO_CALIBRATION_TRACKED_CAMERAS_H_
#define KINEGRAPH_CORE_IO_CALIBRATION_TRACKED_CAMERAS_H_

#include <string>

#include "core/geometry/camera.h"

namespace kinegraph {

// Like WriteCameras (calibration.h), but also stores `tracks`, the fingerprint
// of the tracks to which the cameras belong (side_files.h), unless it is empty.
void WriteTrackedCameras(const std::string& path, const CameraRig& cameras,
                         const std::string& refinement,
                         const std::string& tracks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CALIBRATION_TRACKED_CAMERAS_H_
