// Posture as evidence across a short gap: limbs keep their position.
#ifndef KINEGRAPH_CORE_IDENTITY_POSTURE_H_
#define KINEGRAPH_CORE_IDENTITY_POSTURE_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/identity/tracklet.h"

namespace kinegraph {

// Root mean square distance of the limbs after aligning both headings [m]; `up`
// is a unit vector. nullopt if there are too few common joints or a heading is
// unknown.
std::optional<double> PostureDistance(const LimbPosture& a,
                                      const LimbPosture& b,
                                      const Eigen::Vector3d& up);

class PostureModel {
 public:
  // Learns from people present at the same time how similar the postures of two
  // people in this recording are.
  PostureModel(const std::vector<Tracklet>& tracklets,
               const Eigen::Vector3d& up);

  // Log likelihood ratio [nats] of the posture `to`, `gap_s` after `from`, for
  // the same person against another. 0 without a PostureDistance.
  double LogRatio(const LimbPosture& from, const LimbPosture& to,
                  double gap_s) const;
  double strangers_m() const { return strangers_m_; }

 private:
  Eigen::Vector3d up_;
  // Median PostureDistance between two different people at the same time [m];
  // 0.28 if the recording has too few pairs.
  double strangers_m_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_POSTURE_H_
