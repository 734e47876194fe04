// One joint of one person between two gaps: what every offline filter works on.
#ifndef KINEGRAPH_SOLVERS_FILTERS_JOINT_SEGMENT_H_
#define KINEGRAPH_SOLVERS_FILTERS_JOINT_SEGMENT_H_

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// One row a time, one column a coordinate.
using Samples = Eigen::MatrixXd;

// Entries are frames, from the first that sampled the joint to the last; both
// ends are samples.
struct JointSegment {
  std::vector<double> times_s;  // ascending, since the track's first frame
  Samples positions_m;          // n x 3, world; linear between samples
  std::vector<char> sampled;    // else bridged
  // Of the samples [m^2]; one a frame, without meaning where not sampled or not
  // asked for.
  std::vector<Eigen::Matrix3d> covariances_m2;
  JointClass joint_class = JointClass::kOther;
  // For a rule of the cut-off: the one of the whole body [Hz]; else the rule
  // is asked.
  std::optional<double> cutoff_hz;
};

struct SegmentEstimate {
  Samples positions_m;  // n x 3
  // One a frame [m^2]; empty for methods that give none.
  std::vector<std::optional<Eigen::Matrix3d>> covariances_m2;
  // By coordinate, what a rule chose [Hz]; empty where none was asked.
  std::vector<double> cutoffs_hz = {};
};

using SegmentFilter = std::function<SegmentEstimate(const JointSegment&)>;

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_JOINT_SEGMENT_H_
