// Velocities and accelerations against true ones.
#ifndef KINEGRAPH_CORE_EVALUATION_DERIVATIVES_H_
#define KINEGRAPH_CORE_EVALUATION_DERIVATIVES_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

struct DerivativeOptions {
  double rate_hz = 0.0;                           // of the tracks
  std::vector<FrameRange> frames;                 // of the truth; none: all
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  // in the world
};

// Sums over frames of a joint, or of all.
struct DerivativeErrors {
  int64_t count = 0;
  double velocity_rms_m_s = 0.0;
  double speed_bias_m_s = 0.0;  // mean of speed found less true
  double acceleration_rms_m_s2 = 0.0;
  double acceleration_bias_m_s2 = 0.0;  // of the lengths
  int64_t peaks = 0;
  double peak_error_percent = 0.0;  // mean of found less true, of the true
  double peak_instant_ms = 0.0;     // mean distance in time
};

// Where the frames are that are scored.
enum class DerivativeScope { kAll, kContacts };
inline constexpr int kDerivativeScopes = 2;

struct DerivativeResult {
  std::vector<std::string> joints;  // common to both, in the truth's order
  // By scope; of each joint, and of all together.
  std::array<std::vector<DerivativeErrors>, kDerivativeScopes> by_joint;
  std::array<DerivativeErrors, kDerivativeScopes> all;
  // Squared errors, a unit a true person in a frame, a series a person.
  std::array<std::vector<RatioSeries>, kDerivativeScopes> velocity_m2_s2;
  std::array<std::vector<RatioSeries>, kDerivativeScopes> acceleration_m2_s4;
  int64_t contacts = 0;
};

// Of truth and tracks alike: velocity and acceleration are central differences
// of the positions of three frames that follow each other, at `rate_hz`, so
// both lose the same of what is faster than that. People are paired as
// EvaluateMpjpe does, and must be the same ones in all three.
//
// A contact is an instant at which an ankle of the truth that goes down is
// slowed by more than one g: the greatest such acceleration within 0.1 s.
// Frames within 0.1 s of one are those around contacts. A peak is the greatest
// true acceleration of a joint within 0.25 s that is more than twice the
// joint's root mean square; the one found is the greatest within 0.1 s of it.
DerivativeResult EvaluateDerivatives(const TrackSequence& truth,
                                     const TrackSequence& tracks,
                                     const DerivativeOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_DERIVATIVES_H_
