// One joint of one person between two gaps: the input of every offline filter.
#ifndef KINEGRAPH_SOLVERS_FILTERS_JOINT_SEGMENT_H_
#define KINEGRAPH_SOLVERS_FILTERS_JOINT_SEGMENT_H_

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// One row per time, one column per coordinate.
using Samples = Eigen::MatrixXd;

// The mean step between ascending times, two or more.
inline double MeanStep(const std::vector<double>& times) {
  return (times.back() - times.front()) / static_cast<double>(times.size() - 1);
}

// The times that are `sampled`, and the rows of values there.
struct SampledRows {
  std::vector<double> times;
  Samples values;
};
inline SampledRows SampledRowsOf(const std::vector<double>& times,
                                 const std::vector<char>& sampled,
                                 const Samples& values) {
  SampledRows rows;
  rows.values.resize(values.rows(), values.cols());
  for (size_t i = 0; i < times.size(); ++i) {
    if (!sampled[i]) continue;
    rows.values.row(static_cast<Eigen::Index>(rows.times.size())) =
        values.row(static_cast<Eigen::Index>(i));
    rows.times.push_back(times[i]);
  }
  rows.values.conservativeResize(static_cast<Eigen::Index>(rows.times.size()),
                                 Eigen::NoChange);
  return rows;
}

// One entry per frame, from the first sample of the joint to the last; both
// ends are samples.
struct JointSegment {
  std::vector<double> times_s;  // ascending, since the track's first frame
  Samples positions_m;          // n x 3, world; linear between samples
  std::vector<char> sampled;    // else bridged
  // Covariances of the samples [m^2], one per frame; undefined where not
  // sampled or not requested.
  std::vector<Eigen::Matrix3d> covariances_m2;
  JointClass joint_class = JointClass::kOther;
  // The cut-off of the whole body [Hz], if a rule has already chosen it; else
  // the rule is applied to the joint.
  std::optional<double> cutoff_hz;
};

struct SegmentEstimate {
  Samples positions_m;  // n x 3
  // One per frame [m^2]; empty for methods without covariances.
  std::vector<std::optional<Eigen::Matrix3d>> covariances_m2 = {};
  // Per coordinate, the cut-off chosen by a rule [Hz]; empty if no rule was
  // used.
  std::vector<double> cutoffs_hz = {};
  // n x 3, by the method's own model; empty for methods without one.
  Samples velocities_m_s = {};
  Samples accelerations_m_s2 = {};
};

using SegmentFilter = std::function<SegmentEstimate(const JointSegment&)>;

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_JOINT_SEGMENT_H_
