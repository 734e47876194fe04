// Posture as evidence across a short gap: limbs stay where they were.
#ifndef KINEGRAPH_CORE_IDENTITY_POSTURE_H_
#define KINEGRAPH_CORE_IDENTITY_POSTURE_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/identity/tracklet.h"

namespace kinegraph {

// Shoulders to wrists and hips to ankles from the trunk's centre, in world axes
// [m]; NaN where a joint has no position. Empty: not known.
struct LimbPosture {
  std::vector<Eigen::Vector3d> limbs_m;
  Eigen::Vector3d across_m = Eigen::Vector3d::Zero();
};

LimbPosture PostureOf(const Tracklet& tracklet, size_t frame_idx);

// Root mean square distance of the limbs when both face the same way [m]; `up`
// is a unit vector. nullopt where too few joints are common or a heading is not
// known.
std::optional<double> PostureDistance(const LimbPosture& a,
                                      const LimbPosture& b,
                                      const Eigen::Vector3d& up);

class PostureModel {
 public:
  // Learns from people who are there at once how alike two people of this
  // recording hold themselves.
  PostureModel(const std::vector<Tracklet>& tracklets,
               const Eigen::Vector3d& up);

  // Log likelihood ratio [nats] of the second posture, so long after the first,
  // for the same person and for another.
  double LogRatio(const LimbPosture& from, const LimbPosture& to,
                  double gap_s) const;
  double strangers_m() const { return strangers_m_; }

 private:
  Eigen::Vector3d up_;
  double strangers_m_;  // median distance of two people
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_POSTURE_H_
