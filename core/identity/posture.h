// Posture as evidence across a short gap: limbs stay where they were.
#ifndef KINEGRAPH_CORE_IDENTITY_POSTURE_H_
#define KINEGRAPH_CORE_IDENTITY_POSTURE_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/identity/tracklet.h"

namespace kinegraph {

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
