// Properties of a motion without a ground truth (jitter, smoothness, constancy
// of the body), coverage of the true people, and delay.
#ifndef KINEGRAPH_CORE_EVALUATION_MOTION_H_
#define KINEGRAPH_CORE_EVALUATION_MOTION_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/frame_range.h"
#include "core/base/ids.h"
#include "core/data/pose.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

struct MotionOptions {
  std::vector<FrameRange> frames;  // empty: all
};

struct MotionResult {
  // The acceleration uses only shoulders, elbows, wrists, hips, knees and
  // ankles (all joints of a skeleton that has none of these), the spread of
  // lengths only the twelve bones between them, to be comparable between
  // skeletons.
  //
  // Mean of |p(k+1) - 2 p(k) + p(k-1)| rate^2 over joints that are observed in
  // three consecutive frames [m/s^2]; NaN if there are none.
  double acceleration_m_s2 = 0.0;
  int64_t acceleration_count = 0;
  Interval acceleration_interval;  // bootstrap of blocks within each person
  // Mean over bones and people of the standard deviation of the bone's length
  // over time, wherever both ends have a position [m].
  double bone_length_spread_m = 0.0;
  int64_t bone_count = 0;  // bones times people, with at least two frames each
};

// `frame_rate_hz` > 0, else OptionError.
MotionResult EvaluateMotion(const TrackSequence& tracks, double frame_rate_hz,
                            const MotionOptions& options = {},
                            const BootstrapOptions& bootstrap = {});

// Share of the true person-frames with an output pose within 0.5 m (mean over
// the joints of the same name).
Share EvaluateCoverage(const TrackSequence& truth, const TrackSequence& tracks,
                       const std::vector<FrameRange>& frames = {});

// ---- Smoothness. The caller fixes the person-frames of the units, so that
// several results can be compared frame by frame.

// The frames of a person, ascending.
struct PersonFrames {
  TrackId id;
  std::vector<int64_t> frames;
};
// For all people in the tracks, by ascending id.
std::vector<PersonFrames> PersonFramesOf(const TrackSequence& tracks);

// |difference of order `order` of the position| rate^order, summed over the
// body joints (those of MotionResult's acceleration) that are observed in order
// + 1 consecutive frames, of which the unit's frame is the first: acceleration
// [m/s^2] for 2, jerk [m/s^3] for 3. One series per person, one unit per frame;
// the pooled ratio is the mean over joints.
std::vector<RatioSeries> DifferenceSeries(
    const TrackSequence& tracks, const std::vector<PersonFrames>& people,
    int order, double rate_hz);

// Power of a body joint's position above 6 Hz [m^2], x, y and z together (the
// mean square of that part of the motion). Welch (1967): segments of two
// seconds with half overlap, each detrended and tapered by a Hann window. A
// segment includes the joints with a position, observed or inferred, in all its
// frames. One series per person, one unit per segment, even without joints.
// Empty series when the rate is too low for the cut-off.
std::vector<RatioSeries> PowerSeries(const TrackSequence& tracks,
                                     const std::vector<PersonFrames>& people,
                                     double rate_hz);

// The delay of `tracks` behind `reference` [s] that maximises the normalised
// cross-correlation of their velocities within 0.4 s (Knapp and Carter 1976,
// without weighting), all common body joints and axes together; a parabola
// through the maximum and its neighbours gives fractions of a frame. `rate_hz`
// (> 0, else OptionError) and `frames` (empty: all) are the tracks'. People are
// paired frame by frame within 0.5 m. Negative: tracks lead. nullopt when the
// overlap is too short, there is no motion, or the correlation has no maximum
// within 0.4 s.
std::optional<double> EstimateLag(const TrackSequence& reference,
                                  const TrackSequence& tracks, double rate_hz,
                                  const std::vector<FrameRange>& frames = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MOTION_H_
