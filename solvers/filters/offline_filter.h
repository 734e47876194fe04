// The classical smoothers, behind the interface of every estimator.
#ifndef KINEGRAPH_SOLVERS_FILTERS_OFFLINE_FILTER_H_
#define KINEGRAPH_SOLVERS_FILTERS_OFFLINE_FILTER_H_

#include <memory>

#include "core/tracking/estimator.h"
#include "solvers/filters/joint_points.h"
#include "solvers/filters/joint_segment.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// Collects a person's whole life, filters each joint alone in Finish(), and
// every final pose comes then. Samples of a joint are its points as JointPoints
// finds them.
//
// Gaps are treated alike for every filter: between two samples at most
// `max_gap_s` apart the joint is bridged and inferred; a longer gap parts the
// signal into segments that know nothing of each other, and the joint is
// missing in it, as before its first and after its last sample. Bridged
// positions are linear between the samples before anything is filtered; a
// filter that does without them uses the samples alone. Where `cutoff_per` is
// the body, a filter whose cut-off a rule chooses runs twice: the second time
// all joints have the median of what was chosen, each as often as it has
// frames.
//
// Last() is the newest initial pose and Predict() holds it: not meant to serve
// association. Throws OptionError for bad options; Finish() passes on what
// `filter` throws.
std::unique_ptr<Estimator> MakeOfflineFilter(
    const SceneModel& scene, const OfflineFilterOptions& options,
    JointPoints points, SegmentFilter filter);

// Each checks its options against the frame rate [Hz] (OptionError). Filters
// that need uniform time throw InputError for a segment without.
//
// What they make of bridged frames: the Gaussian, the centred median, the
// recursive ones and Savitzky-Golay take the linear bridge for samples.
// One-Euro and the trailing median hold their last value. The others go over
// the gap by their own model.
SegmentFilter PointsAsTheyAre(PointCovariances covariances);
SegmentFilter CentredGaussianFilter(const CentredGaussianOptions& options);
SegmentFilter HampelMedianFilter(const HampelMedianOptions& options);
SegmentFilter OneEuroFilter(const OneEuroOptions& options);
// Both on the options of `butterworth`.
SegmentFilter ButterworthFilter(const ButterworthOptions& options,
                                double rate_hz,
                                CutoffPer per = CutoffPer::kJoint);
SegmentFilter CriticallyDampedFilter(const ButterworthOptions& options,
                                     double rate_hz,
                                     CutoffPer per = CutoffPer::kJoint);
SegmentFilter SavitzkyGolayFilter(const SavitzkyGolayOptions& options,
                                  double rate_hz);
SegmentFilter LoessFilter(const LoessOptions& options);
SegmentFilter TrendPointFilter(const TrendOptions& options);
// Fewer than 2 m + 1 samples, m the derivative that is rough, stay as they are:
// too few to choose a smoothness by.
SegmentFilter SmoothingSplineFilter(const SmoothingSplineOptions& options,
                                    double rate_hz,
                                    CutoffPer per = CutoffPer::kJoint);
SegmentFilter QuinticSplineFilter(const SmoothingSplineOptions& options,
                                  double rate_hz,
                                  CutoffPer per = CutoffPer::kJoint);
SegmentFilter WhittakerFilter(const WhittakerOptions& options, double rate_hz,
                              CutoffPer per = CutoffPer::kJoint);
SegmentFilter KalmanPointFilter(const KalmanOptions& options);
SegmentFilter RtsPointSmoother(const KalmanOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_OFFLINE_FILTER_H_
