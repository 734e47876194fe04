// Converts estimates and weights to the poses that are written.
#ifndef KINEGRAPH_SOLVERS_GRAPH_OUTCOME_H_
#define KINEGRAPH_SOLVERS_GRAPH_OUTCOME_H_

#include <vector>

#include "core/skeleton/skeleton.h"
#include "core/tracking/estimator.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Number of views of the chain's frame `k` whose weight makes them inliers.
int CountInliers(const JointChain& chain, size_t k, double inlier_weight);

// One joint's result of a solve, over a range of frames.
struct JointOutcome {
  StateChain states;
  std::vector<double> weights;  // of the measurements
  std::vector<char> gated;
};

// Views that have supported one joint so far.
struct JointSupport {
  bool by_two_views = false;  // in any frame of the track
  bool by_one_view = false;
  TimeNs last_time = 0;  // of the last frame with an inlier view
};

// Adds the frame at `time`, in which the joint has `inlier_views`.
void Extend(TimeNs time, int inlier_views, JointSupport* support);

// observed: two or more inlier views; inferred: fewer, and the nearest frame
// with an inlier view is within the bridging limit; missing otherwise, or if
// the joint never had two inlier views in one frame.
JointStatus StatusOf(int inlier_views, bool ever_two_views,
                     double nearest_support_s, double bridging_limit_s);

// A final pose with the frame's time, score and matches. Joints, weights and,
// if requested, covariances and derivatives have entries but no values yet:
// WriteJoint fills them in.
FinalPose PoseOf(const FrameRecord& record, const SceneModel& scene,
                 bool covariances);

// Writes joint `joint_idx`, whose chain is given, of the problem's frame `k`
// into the pose. `covariance` [m^2]: null if there is none.
void WriteJoint(const JointChain& chain, size_t k, int joint_idx,
                JointStatus status, int inlier_views,
                const Eigen::Matrix3d* covariance, PersonPose* pose);

// A bone of a person and its length.
struct KnownBone {
  Bone ends;
  double length_m = 0.0;
};

// Marks joints as missing whose position is too uncertain. A joint is unsure
// when its reported standard deviation, along the worst direction, exceeds half
// the length of its longest bone or, if that is unknown or (as in the face)
// less than a third of the body's longest bone, half of the latter. An unsure
// joint is kept if bones whose estimated length differs from the known length
// by at most half of it connect the joint to a sure joint or to most of the
// body. A joint without a covariance is kept, and so is every joint if no bone
// is known. Called once per pose, after WriteJoint, so that every output of a
// track (JSON, TRC, BVH, glTF, the HTML page) is consistent.
void DropUnsureJoints(const std::vector<KnownBone>& bones, PersonPose* pose);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_OUTCOME_H_
