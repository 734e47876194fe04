// Is it the estimate or the annotation that is wrong? What single views say of
// parts that PCP counts wrong.
//
// In each view the detection of the annotated person is chosen by the
// annotation alone, from joints that are not the part's: neither the estimate
// nor the joints in question choose their own witness. A view then agrees with
// a pose or does not, by the distance of the pose's two ends from the rays
// through the detected ends [m], which the image bounds from below whatever the
// depth. An error of half the part's length, PCP's limit, shows on average
// sqrt(2/3) of itself in one view; beyond that a view does not agree with a
// pose, within half of that it does, and in between it says nothing.
//
// Two rules, for limbs whose ends detectors find (not head and torso, whose
// ends are computed):
// - the estimate's: two or more confident views agree with the estimate and not
//   with the annotation, and none the other way round;
// - the views' own, without any estimate: the ends triangulated from all
//   confident views agree with every one of them, and the annotation would be
//   wrong against them by PCP's mean rule.
#ifndef KINEGRAPH_CORE_EVALUATION_ANNOTATION_AUDIT_H_
#define KINEGRAPH_CORE_EVALUATION_ANNOTATION_AUDIT_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "core/base/options.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/evaluation/pcp.h"
#include "core/geometry/camera.h"

namespace kinegraph {

struct AuditOptions {
  // Both ends of the part, as the detector gives it.
  double min_confidence = 0.5;
  // A detection is the annotated person's when their other body joints are at
  // most this far apart on average, as a share of the image width (50 px on
  // Shelf, by which its README counts matches), over at least so many joints,
  // and no other annotated person is nearer.
  double max_person_share = 0.05;
  int64_t min_other_joints = 4;
  // Mean distance of both ends as a share of the part's length.
  double disagree_share = 0.408;  // sqrt(2/3) of PCP's 0.5
  double agree_share = 0.204;     // half of that
  int64_t min_views = 2;

  void Describe(OptionVisitor& visitor);
};

// The two ends of a part: as PCP's table of parts has them.
template <typename T>
using Ends = std::array<T, 2>;

enum class ViewVerdict {
  kNoDetection,  // nobody there who is the annotated person
  kUnsure,       // an end was not found, or not with enough confidence
  kSilent,       // neither clearly with nor against one of the two
  kBoth,         // agrees with both
  kNeither,      // with none of them
  kEstimate,     // agrees with the estimate and not with the annotation
  kAnnotation,   // the other way round
};
const char* ToString(ViewVerdict verdict);  // "no detection", "estimate", ...

struct ViewEvidence {
  int view_idx = 0;
  ViewVerdict verdict = ViewVerdict::kNoDetection;
  int detection_idx = -1;  // index_in_file
  Ends<double> confidence{};
  Ends<std::optional<Eigen::Vector2d>> detected_px;  // raw pixels
  Ends<std::optional<Eigen::Vector2d>> annotation_px;
  Ends<std::optional<Eigen::Vector2d>> estimate_px;
  // Mean over both ends: distance in the image [px] and from the rays [m].
  double annotation_mean_px = 0.0;
  double estimate_mean_px = 0.0;
  double annotation_m = 0.0;
  double estimate_m = 0.0;
  // The same of the estimate made without this view; nullopt when that has not
  // both ends, or there is none.
  Ends<std::optional<Eigen::Vector2d>> held_out_px;
  std::optional<double> held_out_mean_px;
  std::optional<double> held_out_m;

  bool confident() const {
    return verdict != ViewVerdict::kNoDetection &&
           verdict != ViewVerdict::kUnsure;
  }
};

enum class AuditVerdict {
  kNotAuditable,   // head or torso, nobody found, or an end missing
  kUndecided,      // too few views say anything
  kDisputed,       // views on both sides
  kEstimateWrong,  // enough views with the annotation, none against it
  kContradicted,   // enough views with the estimate, none with the annotation
};
inline constexpr int kAuditVerdictCount = 5;
const char* ToString(AuditVerdict verdict);  // "contradicted", ...

struct AuditCase {
  LostPart lost;
  AuditVerdict verdict = AuditVerdict::kNotAuditable;
  // Contradicted, and enough of those views agree with the estimate made
  // without them too.
  bool held_out_confirmed = false;
  // The views' own rule holds.
  bool refuted_by_views = false;
  std::vector<ViewEvidence> views;
};

// What names a part of a person in a frame.
using PartKey = std::tuple<int64_t, int64_t, int>;  // actor, frame, part

struct AuditResult {
  AuditOptions options;
  std::vector<AuditCase> cases;  // of every lost part, in their order
  // Of all annotated limbs scored, lost or not: how many enough confident views
  // see (and agree upon), and how many of those refute the annotation.
  int64_t limbs = 0;
  int64_t limbs_seen = 0;
  int64_t limbs_agreed = 0;
  std::set<PartKey> refuted_by_views;
  // Those of them in which three or more views took part: of two rays an
  // agreement is easily had.
  std::set<PartKey> refuted_by_three_views;

  std::set<PartKey> Contradicted() const;
  std::set<PartKey> HeldOutConfirmed() const;
  int64_t Count(AuditVerdict verdict) const;
};

// What an audit looks at. Cameras are in the order of the detections' views.
struct AuditInput {
  const TrackSequence* truth = nullptr;
  const TrackSequence* tracks = nullptr;  // the estimate that was scored
  const PcpResult* pcp = nullptr;         // its scores
  const DetectionSequence* detections = nullptr;
  const CameraRig* cameras = nullptr;
  // Tracks made without each view in turn; empty: not at hand.
  std::vector<const TrackSequence*> held_out;
  // Views that are no witnesses.
  std::set<int> without_views;
};

// Throws OptionError for options out of range.
AuditResult AuditAnnotation(const AuditInput& input,
                            const AuditOptions& options = {});

// `result` with some parts not counted, as if the ground truth lacked them.
PcpResult WithoutParts(PcpResult result, const std::set<PartKey>& parts);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_ANNOTATION_AUDIT_H_
