// What a mode adds to the paper's association: which pairs may not be matched,
// which new people are nobody new.
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

// The tracker's view of the frame at hand.
struct AssociationState {
  const SceneModel& scene;
  const FrameClock& clock;
  const LookRhythm& rhythm;
  const TimeNs& time;
  const FrameObservations& observations;
  const std::vector<std::unique_ptr<Track>>& tracks;
  // [view][track]: index of the observation, or -1.
  const std::vector<std::vector<int>>& matches;
  // Epipolar distance at which two views of somebody new contradict.
  double alpha_new_px = 0.0;
};

// The paper's policy, which adds nothing. The tracker calls the functions of a
// frame in the order in which they stand here. Pairs are row-major, tracks x
// observations of the view.
class AssociationPolicy {
 public:
  virtual ~AssociationPolicy() = default;

  // What was learnt of the frames so far says nothing of those to come.
  virtual void StartAnew() {}
  // Before a view is matched: marks pairs that may not match, or leaves
  // `forbidden` empty.
  virtual void Forbid(size_t /*view_idx*/, std::vector<char>* /*forbidden*/) {}
  // After all views were matched: true for a second matching of the view, with
  // all pairs marked but those that may be matched yet.
  virtual bool MatchesAgain(size_t /*view_idx*/,
                            std::vector<char>* /*forbidden*/) {
    return false;
  }
  // After the updates: the track, by its index, that was recovered with
  // detections of somebody else, as this person shows.
  virtual std::optional<size_t> FalseRecovery(const NewPerson&) const {
    return std::nullopt;
  }
  // Updates and new people of the frame are known.
  virtual void LearnUpdates() {}
  // Whether an update counts for the life of its track.
  virtual bool Counts(const Track&) const { return true; }
  // Whether people of whom a frame shows fewer joints than a new person needs
  // begin once they have been seen for long enough, and, of all that are seen
  // in the frame, those that have.
  virtual bool AwaitsSlight() const { return false; }
  virtual void SeeSlight(std::vector<NewPerson>*) {}
  virtual bool MayBegin(const NewPerson&) const { return true; }
  virtual void LearnBeginning(const NewPerson&, TrackId) {}
};

// Whether most of the joints that both have seen (kObserved), three or more,
// are nearer than `within_m`. Where the others are is a prediction's word, and
// of two views one joint may be triangulated metres off.
bool SeenAtOnePlace(const Pose3d& a, const Pose3d& b, double within_m);

// That of `rules`; `state` must outlive it.
std::unique_ptr<AssociationPolicy> MakeAssociationPolicy(
    AssociationRules rules, const AssociationState& state);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_TRACKING_ASSOCIATION_POLICY_H_
