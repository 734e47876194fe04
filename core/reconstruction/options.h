// Options of triangulation and of new people, tables [reconstruction] and
// [initialisation]. "The paper" is Chu et al. (2021).
#ifndef KINEGRAPH_CORE_RECONSTRUCTION_OPTIONS_H_
#define KINEGRAPH_CORE_RECONSTRUCTION_OPTIONS_H_

#include "core/base/options.h"

namespace kinegraph {

enum class ConflictOrder {
  kView,        // pairs in the order of the views, as in the authors' code
  kWorstFirst,  // the most negative pair first
};

// The measurement of a view that counts as its newest.
enum class NewestRule {
  kPose,   // its newest 2D pose as a whole
  kJoint,  // for each joint the newest measured (Chen et al. 2020)
};

// The joints without a triangulation that count against an update.
enum class LostRule {
  kSeen,          // every joint seen by a view (the paper's rule)
  kContradicted,  // joints measured by two views that disagree
};

struct ReconstructionOptions {
  // The newest 2D pose of each view is used while it is younger than this.
  double tau_frames = 3.0;
  // DLT rows are weighted by exp(-lambda_t age).
  double lambda_t_per_frame = 5.0;
  NewestRule newest = NewestRule::kPose;
  // Chen et al. 2020: a person is triangulated again as each view is matched,
  // so that the next view is compared with the result. Used if the affinity is
  // cross_view.
  bool incremental = false;
  bool joints_filter = true;
  double alpha_epi_px = 60.0;
  ConflictOrder conflict_order = ConflictOrder::kView;
  // The update fails when more than this share of the association joints seen
  // in this frame is lost, i.e. has no triangulation.
  double max_lost_share = 1.0 / 3.0;
  // Graph mode: a joint found in one view and missed in the others counts
  // neither as lost nor as seen; its measurement still reaches the estimator.
  // One contradicted joint is always allowed, but at least a quarter of all
  // seen joints must be triangulated. Paper mode counts all seen joints.
  LostRule lost = LostRule::kContradicted;

  // A joint behind a camera that measured it is rejected. The authors' code has
  // no such check.
  bool require_in_front = true;

  void Describe(OptionVisitor& visitor);
};

enum class InitialisationRule {
  kAffinitySum,       // the paper's text: sum of epipolar affinities, E > 0
  kWeightedDistance,  // the authors' code: confidence-weighted mean distance
};

struct InitialisationOptions {
  InitialisationRule rule = InitialisationRule::kAffinitySum;
  double alpha_group_px = 60.0;   // epipolar distance scale of the grouping
  double alpha_filter_px = 60.0;  // of the joints filter at initialisation
  // Detections are used when their mean confidence over the valid joints (under
  // detections.zero_confidence = "position": all joints) is above this.
  double min_confidence = 0.0;
  // affinity_sum: common joints that a pair must have, of 17, scaled to the
  // skeleton's association joints.
  double min_common_joints = 10.0;
  // Triangulated joints that a new person must have, of 17, scaled likewise.
  double min_joints = 10.0;
  // weighted_distance: a detection assigned to a group is rejected if its cost
  // with any member of the group is above 1 and its mean confidence above this.
  // The authors' value, not a key.
  double veto_confidence = 0.5;

  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_RECONSTRUCTION_OPTIONS_H_
