// The measures of CMU Panoptic as defined by VoxelPose (Tu et al., ECCV 2020):
// average precision by pose error, recall at 500 mm, MPJPE.
#ifndef KINEGRAPH_CORE_EVALUATION_PANOPTIC_H_
#define KINEGRAPH_CORE_EVALUATION_PANOPTIC_H_

#include <cstdint>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

struct PanopticOptions {
  std::vector<FrameRange> frames;  // of the tracks; empty: all
  std::vector<double> thresholds_m = {0.025, 0.050, 0.075, 0.100, 0.125, 0.150};
  double recall_threshold_m = 0.5;
};

struct PanopticResult {
  std::vector<double> average_precision;  // 0..1, one per threshold
  std::vector<Share> recall;  // true people found, one per threshold
  Share recall_at_limit;      // true people found within recall_threshold_m
  double mpjpe_m = 0.0;       // mean error of these; NaN: there are none
  int64_t found_person_frames = 0;
  // Joints compared: share of a true person's joints that the found pose has.
  // Below one, the scores only cover the existing joints.
  Share joints_compared;
};

// Each found pose is assigned the true person of its frame with the least mean
// distance over the common joints among the first fifteen of the Panoptic
// skeleton; a pose without common joints is a false positive. Poses are sorted
// by descending score (in order, if the tracks have no scores). For each true
// person the first pose within the threshold is correct and every other pose a
// false positive. Precision is made monotonic from the right before it is
// integrated over recall. A skeleton without neck or mid-hip gets the middle of
// the shoulders or hips. True people without mid-hip, frames without true
// people, and true joints that are not observed (confidence of at most 0.1) are
// left out.
PanopticResult EvaluatePanoptic(const TrackSequence& truth,
                                const TrackSequence& tracks,
                                const PanopticOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_PANOPTIC_H_
