// The measures of CMU Panoptic as VoxelPose defines them (Tu et al., ECCV
// 2020): average precision by pose error, recall at 500 mm, MPJPE.
#ifndef KINEGRAPH_CORE_EVALUATION_PANOPTIC_H_
#define KINEGRAPH_CORE_EVALUATION_PANOPTIC_H_

#include <cstdint>
#include <vector>

#include "core/base/frame_range.h"
#include "core/data/pose.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

struct PanopticOptions {
  std::vector<FrameRange> frames;  // of the tracks; none: all
  std::vector<double> thresholds_m = {0.025, 0.050, 0.075, 0.100, 0.125, 0.150};
  double recall_threshold_m = 0.5;
};

struct PanopticResult {
  std::vector<double> average_precision;  // 0..1, one a threshold
  std::vector<Share> recall;              // true people, one a threshold
  Share recall_at_limit;                  // true people within 500 mm
  double mpjpe_m = 0.0;                   // NaN: nobody within 500 mm
  int64_t found_person_frames = 0;
  // Joints compared: those that a found pose has of the ones its true person
  // has. Below one the scores are of the joints that are there.
  Share joints_compared;
};

// Each found pose takes the true person of its frame with the least mean
// distance over the joints that both have, of the first fifteen joints of the
// Panoptic skeleton. Poses by falling score (in order, where the tracks have no
// scores); each true person counts for the first pose that takes it within the
// threshold, every other pose is a false positive. Precision is made falling
// from the right before it is summed over recall. A skeleton without neck or
// mid-hip gets the middle of the shoulders or hips. True people without
// mid-hip and frames without true people are left out; so are true joints that
// are not observed (confidence of at most 0.1).
PanopticResult EvaluatePanoptic(const TrackSequence& truth,
                                const TrackSequence& tracks,
                                const PanopticOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_PANOPTIC_H_
