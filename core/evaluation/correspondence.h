// Correspondence of frames, people and joints between two results, shared by
// every measure.
#ifndef KINEGRAPH_CORE_EVALUATION_CORRESPONDENCE_H_
#define KINEGRAPH_CORE_EVALUATION_CORRESPONDENCE_H_

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/frame_pairing.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Greatest mean distance over joints at which a found person matches a true one
// [m]. All measures use it except parity, HOTA, Panoptic's measures, held-out
// errors (HeldOutSet::pairing_gate_m) and those PCP protocols that match the
// nearest person or set another gate_m.
inline constexpr double kPersonGateM = 0.5;
inline constexpr double kNoGate = std::numeric_limits<double>::infinity();

// The frame numbered `frame`; nullptr if there is none. To find the frame of
// another recording at the same instant, use PairFrames.
const TrackFrame* FindFrame(const TrackSequence& tracks, int64_t frame);
// The frame's people; none for nullptr.
const std::vector<PersonPose>& PeopleOf(const TrackFrame* frame);

// The same joint in two skeletons.
struct JointPair {
  int a = 0;
  int b = 0;
};
using JointPairs = std::vector<JointPair>;

// Each joint with itself.
JointPairs SameJoints(size_t count);
// Joints of the same name, in the order of `a`.
JointPairs CommonJoints(const Skeleton& a, const Skeleton& b);
// Throws InputError naming `file_b` if there are none: a score would wrongly
// report that no person was found.
void RequireCommonJoints(const Skeleton& a, const std::string& file_a,
                         const Skeleton& b, const std::string& file_b);
// The common joints among shoulders, elbows, wrists, hips, knees and ankles,
// the twelve joints that all conventions share. All common joints if there are
// none of these.
JointPairs CommonBodyJoints(const Skeleton& a, const Skeleton& b);

// Mean distance over the joints that both poses have [m], and mean squared
// distance [m^2]; nullopt if there are none.
std::optional<double> MeanDistance(const Pose3d& a, const Pose3d& b,
                                   const JointPairs& joints);
std::optional<double> MeanSquaredDistance(const Pose3d& a, const Pose3d& b,
                                          const JointPairs& joints);

// A pair of row and column of a cost matrix.
struct CostPair {
  int row = 0;
  int column = 0;
  double cost = 0.0;
};

// One-to-one pairs with cost <= gate: the greatest possible number and, among
// those, the least total cost. Entries that are not finite are no candidates.
// Pairs are in row order.
std::vector<CostPair> MatchOneToOne(const Eigen::MatrixXd& cost, double gate);

// MeanDistance of every person of `a` (rows) to every person of `b` (columns);
// NaN where undefined.
Eigen::MatrixXd PersonDistances(const std::vector<PersonPose>& a,
                                const std::vector<PersonPose>& b,
                                const JointPairs& joints);

// A true person of a frame and the found person matched with them (nullptr:
// none).
struct PersonPair {
  int64_t frame = 0;  // of the tracks
  const PersonPose* truth = nullptr;
  const PersonPose* found = nullptr;
};

// All true people of `frames`, in frame order, matched one-to-one within each
// frame by mean distance over `joints` (a: truth, b: tracks). In frames that
// the tracks lack, nobody is found.
std::vector<PersonPair> PairPeople(const FramePairing& frames,
                                   const JointPairs& joints, double gate_m);
// Overload for PairFrames(truth, tracks, ranges).
std::vector<PersonPair> PairPeople(const TrackSequence& truth,
                                   const TrackSequence& tracks,
                                   const JointPairs& joints, double gate_m,
                                   const std::vector<FrameRange>& ranges);

// Sorts scores of person-frames by `actor`, then by `frame`.
template <typename T>
void SortByActorAndFrame(std::vector<T>* scores) {
  std::stable_sort(scores->begin(), scores->end(), [](const T& a, const T& b) {
    return a.actor != b.actor ? a.actor < b.actor : a.frame < b.frame;
  });
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_CORRESPONDENCE_H_
