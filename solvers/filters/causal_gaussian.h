// The estimator of Chu et al. (docs/paper_mode.md): a causal Gaussian over the
// stored poses and a mean velocity (section 3.3, "Temporal information to
// smooth").
#ifndef KINEGRAPH_SOLVERS_FILTERS_CAUSAL_GAUSSIAN_H_
#define KINEGRAPH_SOLVERS_FILTERS_CAUSAL_GAUSSIAN_H_

#include <memory>
#include <vector>

#include "core/tracking/estimator.h"
#include "solvers/filters/options.h"

namespace kinegraph {

// Weights of a causal Gaussian for a list of `length` poses: entry k belongs to
// the pose k places before the newest; zeros at the end are omitted, so there
// may be fewer than `length` weights. The kernel has radius int(4 sigma + 0.5)
// and is normalised; the list is continued by half-sample symmetric reflection
// (d c b a | a b c d | d c b a).
std::vector<double> CausalGaussianWeights(double sigma, int length);

// Poses are stored after smoothing, so the filter is recursive. The pose at
// birth is stored unchanged. A frame without an initial pose stores nothing and
// its final pose is empty. Poses become final at once.
std::unique_ptr<Estimator> MakeCausalGaussian(
    const SceneModel& scene, const CausalGaussianOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_CAUSAL_GAUSSIAN_H_
