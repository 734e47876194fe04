// Which camera a view of the detections belongs to.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_VIEW_PAIRING_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_VIEW_PAIRING_H_

#include <map>
#include <string>
#include <vector>

#include "core/geometry/camera.h"

namespace kinegraph {

// What becomes of a view that no camera belongs to.
enum class UnpairedViews { kRefuse, kLeaveOut };

// For each view the index of its camera: the one `map` (view -> camera) names,
// else the one of the same name, else the one with the same last integer in its
// name ("cam0" and "Camera0"). Throws InputError when a view has no camera or
// more than one candidate, when two views claim one camera, or when `map` names
// what is not there. With kLeaveOut a view without a camera gets -1.
std::vector<int> PairViewsWithCameras(
    const std::vector<std::string>& view_names, const CameraRig& cameras,
    const std::map<std::string, std::string>& map = {},
    UnpairedViews unpaired = UnpairedViews::kRefuse);

// The cameras in the order of the views.
CameraRig CamerasOfViews(const std::vector<std::string>& view_names,
                         const CameraRig& cameras,
                         const std::map<std::string, std::string>& map = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIEW_PAIRING_H_
