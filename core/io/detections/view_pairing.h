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

// What told whose view it is, the surest first.
enum class PairedBy {
  kMap,       // cameras.map
  kName,      // both have the same name
  kWithin,    // the camera's name stands in the view's, or the other way round
  kNumber,    // both names have the same last integer
  kDistinct,  // the same words and numbers tell the names of each apart
  kOrder,     // nothing but the order of the names
};
// "in the order of their names, which are not alike": completes "paired ...".
const char* ToString(PairedBy paired_by);

struct ViewPairing {
  std::vector<int> camera_of_view;      // index of the camera; -1 for none
  PairedBy paired_by = PairedBy::kMap;  // of the view that is least sure
};

// For each view its camera: the one that `map` (view -> camera) names, else the
// one of the same name. The others by the first of the following rules that
// gives each of them a camera of its own; a rule that fits some of them alone
// says nothing, since views 0, 1, 2 may be cameras 1, 2, 3.
//
// The names are taken as words and numbers, whatever their case, separators and
// leading zeros: "cam1" stands in "take_Cam-01_left", not in "cam10". The
// camera whose name is the longest in the view's; the same last integer; the
// same rest without the words that all views, and all cameras, begin and end
// with; and the same place in the order of the names, where there are as many
// views as cameras and no number speaks against it.
//
// Views named in `without` are paired with the others, and need no camera.
// Throws InputError when another view has no camera or more than one candidate,
// when two views claim one camera, or when `map` names what is not there. With
// kLeaveOut a view without a camera gets -1.
ViewPairing PairViewsWithCameras(
    const std::vector<std::string>& view_names, const CameraRig& cameras,
    const std::map<std::string, std::string>& map = {},
    UnpairedViews unpaired = UnpairedViews::kRefuse,
    const std::vector<std::string>& without = {});

// The cameras in the order of the views.
CameraRig CamerasOfViews(const std::vector<std::string>& view_names,
                         const CameraRig& cameras,
                         const std::map<std::string, std::string>& map = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIEW_PAIRING_H_
