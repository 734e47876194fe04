// What a mode adds to the association of Chu et al. (2021; "the paper"): pairs
// that must not be matched, and new people who must not start a track.
#ifndef KINEGRAPH_CORE_TRACKING_ASSOCIATION_POLICY_H_
#define KINEGRAPH_CORE_TRACKING_ASSOCIATION_POLICY_H_

#include <memory>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/reconstruction/initialisation.h"
#include "core/tracking/frame_observations.h"
#include "core/tracking/options.h"
#include "core/tracking/track.h"

namespace kinegraph {

// The tracker's state in the current frame.
struct AssociationState {
  const SceneModel& scene;
  const FrameClock& clock;
  const LookRhythm& rhythm;
  const TimeNs& time;
  const FrameObservations& observations;
  const std::vector<std::unique_ptr<Track>>& tracks;
  // [view][track]: index of the observation, or -1.
  const std::vector<std::vector<int>>& matches;
  // Epipolar distance beyond which two views of a new person conflict.
  double alpha_new_px = 0.0;
};

// The paper's policy, without additions. In each frame the tracker calls Forbid
// and MatchesAgain for each view, FalseRecovery for each new person,
// AwaitsSlight, SeeSlight (if AwaitsSlight returned true), LearnUpdates, Counts
// for each updated track (if the detector ran on the frame), MayBegin for each
// new person, and LearnBeginning for each who starts a track. If all views are
// matched at once (AllViewMatcher), MatchesAgain is not called. Pairs are
// row-major, tracks x observations of the view.
class AssociationPolicy {
 public:
  virtual ~AssociationPolicy() = default;

  // Discards all state: subsequent frames are independent of previous ones.
  virtual void StartAnew() {}
  // Before a view is matched: marks pairs that may not match, or leaves
  // `forbidden` empty.
  virtual void Forbid(size_t /*view_idx*/, std::vector<char>* /*forbidden*/) {}
  // After all views were matched: returns true to match the view a second time,
  // and marks the pairs that must not be matched then.
  virtual bool MatchesAgain(size_t /*view_idx*/,
                            std::vector<char>* /*forbidden*/) {
    return false;
  }
  // After the updates: index of a track that was falsely recovered in this
  // frame, by other detections of the person whom this new person shows.
  virtual std::optional<size_t> FalseRecovery(const NewPerson&) const {
    return std::nullopt;
  }
  // Called once the updates and new people of the frame are known.
  virtual void LearnUpdates() {}
  // Whether an update counts towards the life of its track.
  virtual bool Counts(const Track&) const { return true; }
  // Whether slight people, i.e. those with fewer joints than a new person
  // needs, may start a track once they have been visible for long enough;
  // SeeSlight removes the candidates that have not.
  virtual bool AwaitsSlight() const { return false; }
  virtual void SeeSlight(std::vector<NewPerson>*) {}
  // Whether a new person may start a track.
  virtual bool MayBegin(const NewPerson&) const { return true; }
  // Called when a new person has started this track.
  virtual void LearnBeginning(const NewPerson&, TrackId) {}
};

// Whether most of the joints observed in both (kObserved; at least three, or
// all of a smaller skeleton) are nearer than `within_m`. Other joints are
// predicted, and a joint triangulated from two views may be metres off.
bool SeenAtOnePlace(const Pose3d& a, const Pose3d& b, double within_m);

// The policy for `rules`; `state` must outlive it.
std::unique_ptr<AssociationPolicy> MakeAssociationPolicy(
    AssociationRules rules, const AssociationState& state);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_ASSOCIATION_POLICY_H_
