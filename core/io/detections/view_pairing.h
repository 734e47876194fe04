// Assigns cameras to the views of detections.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_VIEW_PAIRING_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_VIEW_PAIRING_H_

#include <map>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/io/calibration/calibration.h"

namespace kinegraph {

// What happens to a view without a camera.
enum class UnpairedViews { kRefuse, kLeaveOut };

// The rule that paired a view, in order of decreasing reliability.
enum class PairedBy {
  kMap,       // cameras.map
  kName,      // both have the same name
  kWithin,    // one name contains the other
  kNumber,    // both names have the same last integer
  kDistinct,  // equal names, without the words with which all begin or end
  kOrder,     // only the order of the names
};
// Text that completes "paired ...": "by the last number in their names".
const char* ToString(PairedBy paired_by);

struct ViewPairing {
  std::vector<int> camera_of_view;      // index of the camera; -1 for none
  PairedBy paired_by = PairedBy::kMap;  // the least reliable rule used
};

// Finds the camera of each view: the one that `map` (view -> camera) names,
// otherwise the camera with the view's name. The remaining views are paired by
// the first of the following rules that assigns a different camera to each of
// them (with kLeaveOut, to each for which it finds any). A rule that fits only
// some of them is not applied, since views 0, 1, 2 may be cameras 1, 2, 3.
//
// Names are compared as words and numbers, ignoring case, separators and
// leading zeros: "take_Cam-01_left" contains "cam1", but not "cam10". The
// rules are:
// - one name contains the other; of several such cameras, the one with the most
//   words in common is chosen,
// - the last integers of both names are the same,
// - the names are the same after removing the words with which all views, or
//   all cameras, begin and end,
// - the position in the order of the names is the same, if no view has a camera
//   yet, there are as many views as cameras and no number contradicts it.
//
// Views in `without` are paired too, but need no camera. Throws InputError if
// any other view has no camera or several candidates, if two views claim one
// camera, or if `map` has an unknown name. With kLeaveOut a view without a
// camera gets -1.
ViewPairing PairViewsWithCameras(
    const std::vector<std::string>& view_names, const CameraRig& cameras,
    const std::map<std::string, std::string>& map = {},
    UnpairedViews unpaired = UnpairedViews::kRefuse,
    const std::vector<std::string>& without = {});

// The views that are used, with their cameras.
struct UsedViews {
  std::vector<int> views;  // indices into the detections' views
  CameraRig cameras;
  PairedBy paired_by = PairedBy::kMap;
};

// Leaves out the views and cameras named in `without` and, if `options.use`
// selects cameras, the views of other cameras. `cameras` are those that
// ReadCameras returned for `options`. Throws InputError like
// PairViewsWithCameras, for an unknown name in `without`, and if no view is
// left.
UsedViews ChooseViews(const std::vector<std::string>& view_names,
                      const CameraRig& cameras,
                      const CameraReadOptions& options = {},
                      const std::vector<std::string>& without = {});

// Keeps only the views with these indices, in this order.
void KeepViews(const std::vector<int>& views, DetectionSequence* detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIEW_PAIRING_H_
