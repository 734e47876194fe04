// Assigns cameras to the views of detections.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_VIEW_PAIRING_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_VIEW_PAIRING_H_

#include <map>
#include <string>
#include <vector>

#include "core/geometry/camera.h"

namespace kinegraph {

// Treatment of a view without a camera.
enum class UnpairedViews { kRefuse, kLeaveOut };

// Criterion that paired a view, the most reliable first.
enum class PairedBy {
  kMap,       // cameras.map
  kName,      // both have the same name
  kWithin,    // one name contains the other
  kNumber,    // both names have the same last integer
  kDistinct,  // without common words, the names are equal
  kOrder,     // only the order of the names
};
// "in the order of their names, which are not alike": completes "paired ...".
const char* ToString(PairedBy paired_by);

struct ViewPairing {
  std::vector<int> camera_of_view;      // index of the camera; -1 for none
  PairedBy paired_by = PairedBy::kMap;  // of the least certain view
};

// The camera of each view: the one that `map` (view -> camera) names, else the
// one of the same name. The other views are paired by the first of the
// following rules that gives each of them a camera of its own. A rule that fits
// only some is not applied, since views 0, 1, 2 may be cameras 1, 2, 3.
//
// Names are compared as words and numbers, ignoring case, separators and
// leading zeros: "take_Cam-01_left" contains "cam1", but not "cam10". The
// rules: the camera with the longest name that the view's contains, or the
// reverse; the same last integer; the same rest after removing the words with
// which all views, or all cameras, begin and end; and the same position in the
// order of the names, if there are as many views as cameras and no number
// contradicts it.
//
// Views in `without` are paired with the others, and do not need a camera.
// Throws InputError if another view has no camera or several candidates, if two
// views claim one camera, or if `map` names an unknown one. With kLeaveOut a
// view without a camera gets -1.
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
