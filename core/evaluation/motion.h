// What a motion looks like without a ground truth (jitter, constancy of the
// body), and how much of the true people it has.
#ifndef KINEGRAPH_CORE_EVALUATION_MOTION_H_
#define KINEGRAPH_CORE_EVALUATION_MOTION_H_

#include <cstdint>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/bootstrap.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

// Of which joints and bones a motion is judged.
enum class MotionScope {
  // Shoulders, elbows, wrists, hips, knees and ankles, and the twelve bones
  // between them: the same for every skeleton that has them.
  kBody,
  // All joints and bones of the skeleton, face and feet too.
  kAll,
};

struct MotionOptions {
  MotionScope scope = MotionScope::kBody;
  std::vector<FrameRange> frames;  // none: all
};

struct MotionResult {
  // Mean of |p(k+1) - 2 p(k) + p(k-1)| rate^2 over joints that are observed in
  // three frames of consecutive numbers [m/s^2]; NaN when there are none.
  double acceleration_m_s2 = 0.0;
  int64_t acceleration_count = 0;
  Interval acceleration_interval;  // blocks drawn within each person
  // Mean over bones and people of the standard deviation of the bone's length
  // over time, wherever both ends have a position [m].
  double bone_length_spread_m = 0.0;
  int64_t bone_count = 0;  // bones times people, of at least two frames each
};

// `frame_rate_hz` > 0, else OptionError.
MotionResult EvaluateMotion(const TrackSequence& tracks, double frame_rate_hz,
                            const MotionOptions& options = {},
                            const BootstrapOptions& bootstrap = {});

// Share of the true person-frames with an output pose within 0.5 m (mean over
// the joints of the same name).
Share EvaluateCoverage(const TrackSequence& truth, const TrackSequence& tracks,
                       const std::vector<FrameRange>& frames = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MOTION_H_
