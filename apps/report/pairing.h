// Determines the detections that belong to a result's people, their residuals,
// and the colours of people across several results.
#ifndef KINEGRAPH_APPS_REPORT_PAIRING_H_
#define KINEGRAPH_APPS_REPORT_PAIRING_H_

#include <map>
#include <optional>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// The detection of one person in one view.
struct ViewPair {
  int detection = -1;  // position in the view's list; -1: none
  // Mean over found joints that are not rejected; none if these are too few.
  std::optional<double> residual_px = {};
};

// Pairs the people of a frame with its detections: by the matches in the tracks
// if anyone in the frame has any, else one to one in each view, in ascending
// order of the mean pixel distance, which must be below 5 % of the image
// diagonal (50 px if the image size is unknown).
class DetectionPairing {
 public:
  // `cameras` are in the order of the detections' views.
  DetectionPairing(const TrackHeader& tracks, const DetectionHeader& detections,
                   const CameraRig& cameras);

  // [person][view].
  std::vector<std::vector<ViewPair>> Pair(const TrackFrame& tracks,
                                          const DetectionFrame& seen) const;
  // The page's index of a view of the tracks; -1: the detections lack this
  // view.
  int ViewOf(int track_view) const { return view_of_track_view_[track_view]; }

 private:
  std::optional<double> Residual(const PersonPose& person,
                                 const Detection& detection,
                                 const ViewMatch* match, int view) const;
  void PairNearest(const TrackFrame& tracks, const ViewDetections& seen,
                   int view, std::vector<std::vector<ViewPair>>* pairs) const;

  const CameraRig& cameras_;
  std::vector<int> joint_map_;  // the tracks' joint -> the detections'
  int min_shared_joints_;       // with fewer there is no residual
  std::vector<int> view_of_track_view_;
};

// Colours by identity: 0, 1, 2 in order of first appearance. An identity of a
// later result gets the colour of the first result's identity to which it is
// most often nearest (within 0.5 m), or a new colour if there is none.
class Colours {
 public:
  // `lead` is null for the first result.
  Colours(const TrackSequence& tracks, const TrackSequence* lead,
          const Colours* lead_colours);

  const std::vector<TrackId>& ids() const { return ids_; }
  int ColourOf(TrackId id) const { return colour_.at(id); }

 private:
  std::vector<TrackId> ids_;  // in order of first appearance
  std::map<TrackId, int> colour_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_PAIRING_H_
