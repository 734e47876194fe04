// Pairs the frames of two recordings that show the same instant, for every
// comparison.
#ifndef KINEGRAPH_CORE_EVALUATION_FRAME_PAIRING_H_
#define KINEGRAPH_CORE_EVALUATION_FRAME_PAIRING_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"

namespace kinegraph {

// An instant at which both recordings could have a frame.
struct FramePair {
  // The tracks' number for this instant, whether or not they have the frame.
  int64_t frame = 0;
  const TrackFrame* truth = nullptr;   // nullptr: no frame
  const TrackFrame* tracks = nullptr;  // nullptr: no frame; never both null
};

struct FramePairing {
  // Ascending by `frame`, then by the truth's frame. They point into the
  // recordings.
  std::vector<FramePair> pairs;
  bool is_by_time = false;      // else by frame number
  double truth_rate_hz = 0.0;   // 0: unknown
  double tracks_rate_hz = 0.0;  // 0: unknown
  int64_t truth_frames = 0;     // compared, with or without a counterpart
  int64_t truth_between = 0;    // not compared: between the tracks' instants
  double max_gap_s = 0.0;       // between the times of a pair
  // Remarks to be shown with any score of these pairs, a line each: different
  // rates or numbers, contradictions within a file. Usually empty.
  std::vector<std::string> notes;
};

// The names of the two recordings in messages.
struct PairingNames {
  std::string truth = "the ground truth";
  std::string tracks = "the tracks";
};

// Pairs frames by time where both recordings have increasing times and a rate,
// else by frame number. They are also paired by number, with a note, if the
// rates are equal but no two frames coincide in time, or if frames of equal
// number begin simultaneously and end more than half a frame apart because the
// rates differ slightly. Only instants within `frames` (the tracks' numbers;
// empty: all) are returned.
// Nothing is interpolated: at different rates only common instants are
// compared, and frames between them are ignored. Throws InputError naming both
// rates where they differ and no two frames have the same time.
FramePairing PairFrames(const TrackSequence& truth, const TrackSequence& tracks,
                        const std::vector<FrameRange>& frames = {},
                        const PairingNames& names = {});

// Renumbers the frames of `recording` (`names.truth`) like those of `lead`
// (`names.tracks`) at the same instants. Frames between those of the lead are
// dropped, and so are all but the first of frames that get the same number. No
// change if frames are paired by number. Returns the notes. Throws as
// PairFrames does.
std::vector<std::string> NumberFramesLike(const TrackSequence& lead,
                                          const PairingNames& names,
                                          TrackSequence* recording);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_FRAME_PAIRING_H_
