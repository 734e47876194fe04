// Options of triangulation and of new people, tables [reconstruction] and
// [initialisation].
#ifndef KINEGRAPH_CORE_RECONSTRUCTION_OPTIONS_H_
#define KINEGRAPH_CORE_RECONSTRUCTION_OPTIONS_H_

#include "core/base/options.h"

namespace kinegraph {

enum class ConflictOrder {
  kView,        // pairs by the order of the views, as the authors' code
  kWorstFirst,  // the most negative pair first
};

// What counts as the newest measurement of a view.
enum class NewestRule {
  kPose,   // its newest 2D pose, with what that has and lacks
  kJoint,  // joint by joint the newest that it has (Chen et al. 2020)
};

// Which joints without a triangulation speak against an update.
enum class LostRule {
  kSeen,          // every joint that a view sees (the paper's)
  kContradicted,  // those that two views measure and that do not fit
};

struct ReconstructionOptions {
  // The newest 2D pose of each view counts while it is younger than this.
  double tau_frames = 3.0;
  double lambda_t_per_frame = 5.0;  // DLT rows weigh exp(-lambda_t age)
  NewestRule newest = NewestRule::kPose;
  // Chen et al. 2020: a person is triangulated anew as each view is matched, so
  // that the next view is compared with what this one saw. Association reads
  // it where its affinity is cross_view.
  bool incremental = false;
  bool joints_filter = true;
  double alpha_epi_px = 60.0;
  ConflictOrder conflict_order = ConflictOrder::kView;
  // The update fails when more than this share of the joints seen in this
  // frame is left with fewer than two views.
  double max_lost_share = 1.0 / 3.0;
  // Graph mode: where a joint is found in one view and missed in the others,
  // nothing contradicts, and that view alone says something of it. Paper mode
  // counts all that are seen.
  LostRule lost = LostRule::kContradicted;

  // A joint behind a camera that measured it is no joint. The authors' code
  // does not ask.
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
  // Detections take part when their mean confidence over the joints that
  // take part at all (under detections.zero_confidence = "position": all
  // joints) is above this.
  double min_confidence = 0.0;
  // affinity_sum: common joints that a pair must have, as a share of 17 scaled
  // to the skeleton's association joints.
  double min_common_joints = 10.0;
  // Triangulated joints that a new person must have, likewise.
  double min_joints = 10.0;
  // weighted_distance: a pair with a cost above 1 in any member view is vetoed
  // after the assignment when the detection's mean confidence is above this.
  // The authors', no key.
  double veto_confidence = 0.5;

  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_RECONSTRUCTION_OPTIONS_H_
