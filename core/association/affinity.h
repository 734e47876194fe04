// How well a 2D pose fits a person: the paper's Eq. 1, its body-aware baseline,
// and the affinity of Chen et al. (2020, "Cross-View Tracking for Multi-Human
// 3D Pose Estimation at over 100 FPS").
#ifndef KINEGRAPH_CORE_ASSOCIATION_AFFINITY_H_
#define KINEGRAPH_CORE_ASSOCIATION_AFFINITY_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/base/options.h"
#include "core/data/observation.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

enum class AffinityKind {
  kPart,  // mean over the joints with a positive affinity (the paper's)
  kBody,  // mean over all joints (the ablation's baseline)
  // Chen et al.: a sum over joints of what the last 2D joint of this view and
  // the expected 3D joint say.
  kCrossView,
};

// cross_view: what a detected joint is compared with in the image.
enum class Target2d {
  kMatched,    // the joint that was last matched to the person in this view
  kProjected,  // the projection of the person's last 3D joint
};

struct AssociationOptions {
  AffinityKind affinity = AffinityKind::kPart;
  double alpha_2d_px_per_frame = 70.0;
  double lambda_a_per_frame = 3.0;
  // Graph mode: after the first frame without a match the gate of Eq. 1 grows
  // no faster than people move. The paper's grows by alpha_2d a frame and soon
  // reaches strangers. 0: the paper's.
  double max_speed_mps = 3.0;
  // Graph mode: so long a person is expected to go on as their body went; then
  // they stay. 0: expected where they were last seen, the paper's.
  double prediction_s = 0.2;
  // Joints of 17 that must have a positive affinity. Where joints are missing
  // the same share of the joints that both poses have.
  double epsilon_joints = 10.0;
  // Of 17; fewer common joints than this are no match at all.
  double min_common_joints = 6.0;
  // cross_view alone.
  Target2d target_2d = Target2d::kMatched;
  double weight_2d = 0.4;
  double weight_3d = 0.6;
  double alpha_3d_m = 0.15;

  // Set by the tracker from max_speed, no key; 0: the gate is the paper's.
  double reach_m_per_frame = 0.0;
  // Likewise prediction_s in graph mode, 0 in paper mode.
  double horizon_s = 0.0;

  void Describe(OptionVisitor& visitor);
};

// A joint as it was last matched to a person in one view.
struct LastSeenJoint {
  bool valid = false;
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // raw pixels
  double age_frames = 0.0;                       // > 0
};

// A person as association sees them: the last stored pose, in graph mode moved
// to where it is expected, and its age.
struct AssociationTarget {
  const Pose3d* pose = nullptr;
  double age_frames = 0.0;  // > 0
  // cross_view alone: the pose expected now, with the age of what it rests on
  // (0 when views of this very frame are in it); null: `pose` itself.
  const Pose3d* expected = nullptr;
  double expected_age_frames = 0.0;
  // cross_view with Target2d::kMatched: one a joint; null: never seen here.
  const std::vector<LastSeenJoint>* last_seen = nullptr;
};

// A 3D pose projected into one view.
struct ProjectedPose {
  std::vector<Eigen::Vector2d> px;  // raw pixels
  std::vector<char> valid;          // one a joint
};

// Projects the joints listed in `joints`; others become not valid. A joint
// without a position, behind the camera or beyond the lens is not valid.
void ProjectPose(const Pose3d& pose, const Camera& camera,
                 const std::vector<int>& joints, ProjectedPose* projected);

// Affinity of an observation to a projected pose that is `age_frames` old
// (> 0), over the joints listed that both have. 0 means no match; body-aware
// affinities may be negative. `gate_px` is the distance at which the affinity
// of a joint falls to zero (GatePx).
double Affinity(const Observation& observation, const ProjectedPose& projected,
                double age_frames, double gate_px,
                const std::vector<int>& joints,
                const AssociationOptions& options);
// The same with the paper's gate, alpha_2d a frame.
double Affinity(const Observation& observation, const ProjectedPose& projected,
                double age_frames, const std::vector<int>& joints,
                const AssociationOptions& options);

// The gate of a person whose pose is `age_frames` old: alpha_2d a frame; with
// reach_m_per_frame not less than alpha_2d, and not more than that and what a
// person may have moved since.
double GatePx(const Pose3d& pose, double age_frames, const Camera& camera,
              const AssociationOptions& options);

// Chen et al.: sum over the joints listed that the observation has of
//   w2d (1 - d2d / (alpha_2d age2d)) exp(-lambda_a age2d)
// + w3d (1 - d3d / alpha_3d) exp(-lambda_a age3d),
// d2d [px] the distance from `last_seen`, d3d [m] that of the expected joint
// from the detected joint's ray. A term without its joint is zero; a joint
// without both takes no part. 0 where too few take part.
double CrossViewAffinity(const Observation& observation,
                         const std::vector<LastSeenJoint>& last_seen,
                         const Pose3d& expected, double expected_age_frames,
                         const Camera& camera, const std::vector<int>& joints,
                         const AssociationOptions& options);

// One of them, ready for one person after another. Keeps its memory between
// calls.
class AffinityMeasure {
 public:
  virtual ~AffinityMeasure() = default;
  // Whom the calls of Of() that follow are about, in the view of `camera`.
  // What `target` points at must not change before the last of them.
  virtual void SetTarget(const AssociationTarget& target,
                         const Camera& camera) = 0;
  // > 0: may be matched, the greater the better.
  virtual double Of(const Observation& observation) const = 0;
};

std::unique_ptr<AffinityMeasure> MakeAffinityMeasure(
    const AssociationOptions& options, std::vector<int> joints);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_AFFINITY_H_
