// A walking person with swinging limbs, defined at any time.
#ifndef KINEGRAPH_TESTS_CORE_EVALUATION_MARKERS_MOVING_PERSON_H_
#define KINEGRAPH_TESTS_CORE_EVALUATION_MARKERS_MOVING_PERSON_H_

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {

inline Pose3d PoseAt(double t) {
  Pose3d pose = StandingTum14();
  for (size_t j = 0; j < pose.size(); ++j) {
    const auto phase = static_cast<double>(j);
    pose[j].position_m +=
        Eigen::Vector3d(0.10 * std::sin(4.1 * t + phase),
                        0.8 * std::sin(0.7 * t) + 0.12 * std::sin(5.3 * t),
                        0.08 * std::sin(6.7 * t + 2.0 * phase));
  }
  return pose;
}

// Frames at `rate_hz` over `length_s`; `clock` maps a frame's time to that of
// the motion.
template <typename Clock>
TrackSequence Recorded(double rate_hz, double length_s, const Clock& clock) {
  TrackSequence tracks = Tracks({});
  tracks.header.frame_rate_hz = rate_hz;
  for (int k = 0; k < static_cast<int>(rate_hz * length_s); ++k) {
    const double t = k / rate_hz;
    tracks.frames.push_back({k, FromSeconds(t), {Person(0, PoseAt(clock(t)))}});
  }
  return tracks;
}

// Removes pieces of ten frames from each joint, a fraction `share` of all.
inline void LeaveOut(double share, TrackSequence* tracks) {
  Random random(7);
  const size_t joints = tracks->frames.front().people.front().joints.size();
  for (size_t j = 0; j < joints; ++j) {
    for (size_t f = 0; f < tracks->frames.size(); f += 10) {
      if (random.Uniform(0.0, 1.0) > share) continue;
      for (size_t k = f; k < std::min(f + 10, tracks->frames.size()); ++k) {
        tracks->frames[k].people.front().joints[j] = Joint3d{};
      }
    }
  }
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_CORE_EVALUATION_MARKERS_MOVING_PERSON_H_
