// Smoothness of a motion: differences of any order, and the power above a
// frequency. Units are laid out over person-frames that the caller fixes, so
// that several results can be compared frame by frame.
#ifndef KINEGRAPH_CORE_EVALUATION_SMOOTHNESS_H_
#define KINEGRAPH_CORE_EVALUATION_SMOOTHNESS_H_

#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/data/pose.h"
#include "core/evaluation/bootstrap.h"

namespace kinegraph {

// The frames of a person, ascending.
struct PersonFrames {
  TrackId id;
  std::vector<int64_t> frames;
};
// Of everyone in the tracks, by ascending id.
std::vector<PersonFrames> PersonFramesOf(const TrackSequence& tracks);

// |difference of order `order` of the position| rate^order, summed over the
// twelve body joints that are observed in order + 1 consecutive frames: mean
// acceleration [m/s^2] for 2, jerk [m/s^3] for 3. One series a person, one unit
// for each of their frames; the pooled ratio is the mean over joints.
std::vector<RatioSeries> DifferenceSeries(
    const TrackSequence& tracks, const std::vector<PersonFrames>& people,
    int order, double rate_hz);

struct PowerOptions {
  double cutoff_hz = 6.0;  // voluntary movement has little above
  double segment_s = 2.0;  // frequency resolution: 1 / segment_s
};

// Power of a body joint's position above the cut-off [m^2], x, y and z together
// (the mean square of that part of the motion). Welch (1967): segments that
// overlap by half, each freed of its straight line and tapered by a Hann
// window. A joint takes part in a segment when it has a position, observed or
// inferred, in all its frames. One series a person, one unit a segment (whether
// any joint takes part or not). Empty series when the rate is too low for the
// cut-off.
std::vector<RatioSeries> PowerSeries(const TrackSequence& tracks,
                                     const std::vector<PersonFrames>& people,
                                     double rate_hz,
                                     const PowerOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_SMOOTHNESS_H_
