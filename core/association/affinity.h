// Affinity of a 2D pose and a person: Eq. 1 of Chu et al. (2021; "the paper"),
// its body-aware baseline, and that of Chen et al. (2020, "Cross-View Tracking
// for Multi-Human 3D Pose Estimation at over 100 FPS").
#ifndef KINEGRAPH_CORE_ASSOCIATION_AFFINITY_H_
#define KINEGRAPH_CORE_ASSOCIATION_AFFINITY_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "core/assignment/hungarian.h"
#include "core/association/options.h"
#include "core/base/span.h"
#include "core/data/observation.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// A joint as it was last matched to a person in one view.
struct LastSeenJoint {
  bool valid = false;
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // raw pixels
  double age_frames = 0.0;                       // > 0
};

// A person to be matched: the last stored pose (in graph mode moved to the
// position expected now) and its age.
struct AssociationTarget {
  const Pose3d* pose = nullptr;
  double age_frames = 0.0;  // > 0
  // cross_view only: the pose expected now, with the age of the data behind it
  // (0 when it includes views of the current frame); null: `pose` itself.
  const Pose3d* expected = nullptr;
  double expected_age_frames = 0.0;
  // cross_view with Target2d::kMatched: one per joint; null: never seen in this
  // view.
  const std::vector<LastSeenJoint>* last_seen = nullptr;
};

// A 3D pose projected into one view.
struct ProjectedPose {
  std::vector<Eigen::Vector2d> px;  // raw pixels
  std::vector<char> valid;          // one per joint
};

// Projects the joints listed in `joints`; all others become invalid. So does a
// joint without a position, behind the camera or outside the lens' region.
void ProjectPose(const Pose3d& pose, const Camera& camera,
                 const std::vector<int>& joints, ProjectedPose* projected);

// Affinity of an observation to a projected pose of age `age_frames` (> 0),
// over the listed joints that both have. 0 means no match; body-aware
// affinities may be negative. `gate_px` is the distance at which the affinity
// of a joint falls to zero (GatePx).
double Affinity(const Observation& observation, const ProjectedPose& projected,
                double age_frames, double gate_px,
                const std::vector<int>& joints,
                const AssociationOptions& options);

// The gate [px] of a person whose pose is `age_frames` old: alpha_2d times the
// age. If reach_m_per_frame > 0, it is alpha_2d up to an age of one frame and
// then grows at most by the image of reach_m_per_frame per frame (by alpha_2d
// per frame if the pose has no joints or its middle is behind the camera).
double GatePx(const Pose3d& pose, double age_frames, const Camera& camera,
              const AssociationOptions& options);

// Chen et al.: sum, over the listed joints that the observation has, of
//   w2d (1 - d2d / (alpha_2d age2d)) exp(-lambda_a age2d)
// + w3d (1 - d3d / alpha_3d) exp(-lambda_a age3d),
// where d2d [px] is the distance from `last_seen` and d3d [m] that of the
// expected joint from the detected joint's ray. A term whose `last_seen` or
// expected joint is unknown, or behind the camera, is zero; joints with neither
// term do not count. 0 where too few joints count.
double CrossViewAffinity(const Observation& observation,
                         const std::vector<LastSeenJoint>& last_seen,
                         const Pose3d& expected, double expected_age_frames,
                         const Camera& camera, const std::vector<int>& joints,
                         const AssociationOptions& options);

// Matches the observations of one view with targets: an affinity matrix and the
// assignment of the largest total. Reuses its memory between calls.
class ViewMatcher {
 public:
  ViewMatcher(const AssociationOptions& options, std::vector<int> joints)
      : options_(options), joints_(std::move(joints)) {}

  // (*match)[target] is the index of its observation, or -1. A pair is a match
  // only if its affinity is > 0, with no tolerance. Pairs marked in `barred`
  // (row-major targets x observations; empty: none) cannot match.
  void Match(const std::vector<AssociationTarget>& targets,
             Span<Observation> observations, const Camera& camera,
             const std::vector<char>& barred, std::vector<int>* match);

  // Affinities of the last call, row-major targets x observations.
  const std::vector<double>& affinities() const { return affinities_; }

 private:
  // Sets the target that subsequent calls of AffinityOf compare with.
  void SetTarget(const AssociationTarget& target, const Camera& camera);
  // `box` is around the observation's joints.
  double AffinityOf(const AssociationTarget& target,
                    const Observation& observation,
                    const Eigen::AlignedBox2d& box, const Camera& camera) const;

  AssociationOptions options_;
  std::vector<int> joints_;
  HungarianSolver solver_;
  std::vector<double> affinities_;
  std::vector<Eigen::AlignedBox2d> boxes_;  // of the observations
  // The target in this view; not used for cross_view with Target2d::kMatched.
  ProjectedPose projected_;
  Eigen::AlignedBox2d box_;
  double gate_px_ = 0.0;
  // For cross_view with Target2d::kProjected: the projected joints, as if last
  // seen there; else empty.
  std::vector<LastSeenJoint> last_seen_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_AFFINITY_H_
