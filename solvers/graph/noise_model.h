// How far off a detector is, and how much each of its answers tells.
#ifndef KINEGRAPH_SOLVERS_GRAPH_NOISE_MODEL_H_
#define KINEGRAPH_SOLVERS_GRAPH_NOISE_MODEL_H_

#include "core/skeleton/skeleton.h"
#include "solvers/graph/options.h"

namespace kinegraph {

// Where the noise is learnt from the recording its sigmas are widened by this,
// and information is raised by the square: the same curvature at small
// residuals, a robust loss that doubts a little later.
inline constexpr double kLearntWidening = 1.25;

// Confidence as far as it is trusted: GraphOptions::min_confidence to 1.
double TrustedConfidence(const GraphOptions& options, double confidence);

// Standard deviation of one coordinate of a detected joint [px]. It scales with
// the person's size in the image, focal_px / depth_m, because detectors work
// on a person's crop; `depth_m` > 0 is that of the initial pose, so that the
// sigma is constant during a solve.
double PixelSigma(const GraphOptions& options, JointClass joint_class,
                  double confidence, double depth_m, double focal_px);

// Factor on the information of an observation made `dt_s` after the previous
// one of the same joint in the same view: detector errors are correlated over
// correlation_time_s, and a chain of first-order correlated errors carries
// (1 - rho) / (1 + rho), rho = exp(-dt / tau), of the information of as many
// independent ones (variance of the mean of an AR(1) process). So the
// information per second does not grow with the frame rate without bound.
double InformationScale(const GraphOptions& options, double dt_s);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_NOISE_MODEL_H_
