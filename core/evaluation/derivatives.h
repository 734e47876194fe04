// Errors of velocities and accelerations.
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
  std::vector<FrameRange> frames;                 // of the tracks; empty: all
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  // in the world
};

// Errors over the frames of one joint, or of all joints.
struct DerivativeErrors {
  int64_t count = 0;  // one per joint and frame
  double velocity_rms_m_s = 0.0;
  double speed_bias_m_s = 0.0;  // mean of found minus true speed
  double acceleration_rms_m_s2 = 0.0;
  double acceleration_bias_m_s2 = 0.0;  // of the magnitudes
  int64_t peaks = 0;
  // Mean of found minus true, relative to true.
  double peak_error_percent = 0.0;
  double peak_instant_ms = 0.0;  // mean absolute time difference
};

// The frames that are scored: all, and those around contacts.
inline constexpr int kDerivativeScopes = 2;

// How a derivative of the tracks was obtained.
enum class DerivativeSource {
  kDifferences,    // central differences of the positions
  kModelVelocity,  // an acceleration: central differences of the model's
                   // velocities
  kModel,          // PersonPose::derivatives
};

struct DerivativeResult {
  std::vector<std::string> joints;  // common to both, in the truth's order
  // By scope; for each joint, and for all together.
  std::array<std::vector<DerivativeErrors>, kDerivativeScopes> by_joint;
  std::array<DerivativeErrors, kDerivativeScopes> all;
  // Squared errors: one unit per true person and frame, one series per person.
  std::array<std::vector<RatioSeries>, kDerivativeScopes> velocity_m2_s2;
  std::array<std::vector<RatioSeries>, kDerivativeScopes> acceleration_m2_s4;
  int64_t contacts = 0;
  DerivativeSource velocity_source = DerivativeSource::kDifferences;
  DerivativeSource acceleration_source = DerivativeSource::kDifferences;
};

// Velocity and acceleration of the truth are central differences of its
// positions in three consecutive frames, at `rate_hz` or, where the truth has
// only every n-th frame of the tracks, a rate n times lower. Those of the
// tracks are the derivatives of the estimator's model where its poses have
// them; the acceleration of a model that has none is the central difference of
// its velocities. For other poses both are central differences of the
// positions. People are paired as in EvaluateMpjpe, and the pair must be the
// same in all three frames, whatever the source, so that estimators with and
// without derivatives of their own are scored on the same frames.
//
// A contact is an instant at which a descending ankle of the ground truth is
// decelerated by more than one g: the greatest such deceleration within 0.1 s.
// Frames within 0.1 s of a contact count as around it. A peak is the greatest
// true acceleration of a joint within 0.25 s that exceeds twice the joint's
// root mean square; its counterpart is the greatest acceleration found within
// 0.1 s of it.
DerivativeResult EvaluateDerivatives(const TrackSequence& truth,
                                     const TrackSequence& tracks,
                                     const DerivativeOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_DERIVATIVES_H_
