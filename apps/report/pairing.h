// Correspondences on the page: the detections of a result's people and their
// residuals, and the colours of people in several results.
#ifndef KINEGRAPH_APPS_REPORT_PAIRING_H_
#define KINEGRAPH_APPS_REPORT_PAIRING_H_

#include <map>
#include <optional>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// One person in one view.
struct ViewPair {
  int detection = -1;                 // position in the view's list; -1: none
  std::optional<double> residual_px;  // mean over the joints with a weight
};

// Pairs the people of a frame with its detections: by the tracks' own matches
// if they have them, else with the nearest by mean pixel distance.
class DetectionPairing {
 public:
  // `cameras` are in the order of the detections' views.
  DetectionPairing(const TrackHeader& tracks, const DetectionHeader& detections,
                   const CameraRig& cameras);

  // [person][view].
  std::vector<std::vector<ViewPair>> Pair(const TrackFrame& tracks,
                                          const DetectionFrame& seen) const;
  // The page's view for a view of the tracks; -1: the detections lack it.
  int ViewOf(int track_view) const { return view_of_track_view_[track_view]; }

 private:
  std::optional<double> Residual(const PersonPose& person,
                                 const Detection& detection,
                                 const ViewMatch* match, int view) const;
  void PairNearest(const TrackFrame& tracks, const ViewDetections& seen,
                   int view, std::vector<std::vector<ViewPair>>* pairs) const;

  const CameraRig& cameras_;
  std::vector<int> joint_map_;  // the tracks' joint -> the detections'
  std::vector<int> view_of_track_view_;
};

// Colours by identity: 0, 1, 2 in order of first appearance; an identity of a
// later result takes the colour of the one that it is most often nearest to.
class Colours {
 public:
  // `lead` is null for the first result.
  Colours(const TrackSequence& tracks, const TrackSequence* lead,
          const Colours* lead_colours);

  const std::vector<TrackId>& ids() const { return ids_; }
  int ColourOf(TrackId id) const { return colour_.at(id); }
  std::optional<int> Find(TrackId id) const {
    const auto at = colour_.find(id);
    return at == colour_.end() ? std::nullopt : std::optional<int>(at->second);
  }

 private:
  static std::map<TrackId, std::map<TrackId, int>> Votes(
      const TrackSequence& tracks, const TrackSequence& lead);

  std::vector<TrackId> ids_;  // in order of first appearance
  std::map<TrackId, int> colour_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_PAIRING_H_
