// Correspondence of frames, people and joints between two results, which every
// measure uses.
#ifndef KINEGRAPH_CORE_EVALUATION_CORRESPONDENCE_H_
#define KINEGRAPH_CORE_EVALUATION_CORRESPONDENCE_H_

#include <Eigen/Core>
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

// Distance up to which a person found counts as the true one [m]
// (design: covered, identity, one-to-one PCP, held-out pairing).
inline constexpr double kPersonGateM = 0.5;
inline constexpr double kNoGate = std::numeric_limits<double>::infinity();

// By number, within one recording (frames of two: PairFrames); nullptr when
// there is no such frame.
const TrackFrame* FindFrame(const TrackSequence& tracks, int64_t frame);

// The same joint in two skeletons.
struct JointPair {
  int a = 0;
  int b = 0;
};
using JointPairs = std::vector<JointPair>;

// Joints of the same name, in the order of `a`.
JointPairs CommonJoints(const Skeleton& a, const Skeleton& b);
// Throws InputError naming file `b` when there are none: a score would say that
// nobody was found.
void RequireCommonJoints(const Skeleton& a, const std::string& file_a,
                         const Skeleton& b, const std::string& file_b);
// Only shoulders, elbows, wrists, hips, knees and ankles of those: the twelve
// joints that all conventions agree on. All common joints when there are none.
JointPairs CommonBodyJoints(const Skeleton& a, const Skeleton& b);

// Mean distance over the joints that both poses have [m]; nullopt when they
// share none.
std::optional<double> MeanDistance(const Pose3d& a, const Pose3d& b,
                                   const JointPairs& joints);

// Rows and columns of a cost matrix that were put together.
struct CostPair {
  int row = 0;
  int column = 0;
  double cost = 0.0;
};

// One-to-one pairs with cost <= gate: as many as there can be, and of those
// the least total cost. An entry that is not a number is no candidate. Pairs
// come in the order of their rows.
std::vector<CostPair> MatchOneToOne(const Eigen::MatrixXd& cost, double gate);

// MeanDistance of every person of `a` (rows) to every person of `b` (columns);
// NaN where it is undefined.
Eigen::MatrixXd PersonDistances(const std::vector<PersonPose>& a,
                                const std::vector<PersonPose>& b,
                                const JointPairs& joints);

// A true person of a frame and the one found for it (nullptr: none).
struct PersonPair {
  int64_t frame = 0;  // of the tracks
  const PersonPose* truth = nullptr;
  const PersonPose* found = nullptr;
};

// All true people of paired frames, ascending, paired one-to-one in each frame
// by mean distance over `joints` (a: truth, b: tracks).
std::vector<PersonPair> PairPeople(const FramePairing& frames,
                                   const JointPairs& joints, double gate_m);
// The same of all frames in `ranges` that PairFrames pairs.
std::vector<PersonPair> PairPeople(const TrackSequence& truth,
                                   const TrackSequence& tracks,
                                   const JointPairs& joints, double gate_m,
                                   const std::vector<FrameRange>& ranges);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_CORRESPONDENCE_H_
