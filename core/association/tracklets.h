// 2D tracklets: detections of one view linked from frame to frame by the image
// alone, and the tracks that own them.
#ifndef KINEGRAPH_CORE_ASSOCIATION_TRACKLETS_H_
#define KINEGRAPH_CORE_ASSOCIATION_TRACKLETS_H_

#include <Eigen/Geometry>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/span.h"
#include "core/base/time.h"
#include "core/data/observation.h"

namespace kinegraph {

// The tracklets of one view. A detection continues the nearest tracklet within
// a gate if every other tracklet is at least twice as far from the detection
// and every other detection at least twice as far from the tracklet. Otherwise
// tracklets end and new ones begin: short tracklets are harmless, wrong ones
// are not.
//
// A tracklet belongs to the track last matched with its detections, after 0.2 s
// of matches; detections that continue it are assumed to show the same person.
class ViewTracklets {
 public:
  // `joints`: the joints that are compared (Skeleton::association_joints).
  explicit ViewTracklets(std::vector<int> joints)
      : joints_(std::move(joints)) {}

  // The detections of the next frame. `longest_pause_s`: longest interval to be
  // expected between two frames on which the detector runs; tracklets survive
  // it.
  void Follow(Span<Observation> observations, TimeNs time,
              double longest_pause_s);

  // The track that owns the tracklet of this detection, by the detection's
  // index in the last Follow. nullopt if the tracklet was never matched, if the
  // matches with its last track span less than 0.2 s, or if the last match is
  // more than 2 s old.
  std::optional<TrackId> OwnerOf(size_t observation_idx) const;
  // To be called when the detection was matched with a track and agrees with
  // another view of the track.
  void Claim(size_t observation_idx, TrackId track);

 private:
  struct Tracklet {
    TimeNs time = 0;  // of the newest detection
    std::vector<Keypoint> joints;
    Eigen::AlignedBox2d box;
    // The track last matched with the tracklet, and the times of the first and
    // the last of these matches.
    TrackId owner;
    TimeNs since = 0;
    TimeNs until = 0;
  };

  double Distance(const Tracklet& a, const Tracklet& b) const;
  // A detection and a tracklet that it may continue.
  struct Candidate {
    size_t observation = 0;
    size_t tracklet = 0;
    double distance_px = 0.0;
  };
  std::vector<Candidate> Candidates() const;
  // Whether any other detection or tracklet is less than twice as far.
  bool IsAmbiguous(const Candidate& candidate) const;

  std::vector<int> joints_;
  TimeNs now_ = 0;
  std::vector<Tracklet> tracklets_;
  std::vector<Tracklet> seen_;       // buffer of Follow: the next tracklets_
  std::vector<size_t> tracklet_of_;  // [observation]
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_TRACKLETS_H_
