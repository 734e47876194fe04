// The second round of a refinement: with cameras and clocks nearly right, the
// tracker matches more and the noise is the detector's alone.
#ifndef KINEGRAPH_SOLVERS_SCENE_REFINE_AGAIN_H_
#define KINEGRAPH_SOLVERS_SCENE_REFINE_AGAIN_H_

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/tracking/replay.h"
#include "solvers/scene/bundle.h"
#include "solvers/scene/refine.h"

namespace kinegraph {

// A detector's errors last: what a view says of a joint within a second counts
// once, however many frames and stretches it has. The priors' sigmas for that.
BundleOptions WithLastingErrors(BundleOptions options,
                                const SceneSegments& segments);

// Sets what a fit states of its uncertainty.
void StoreUncertainty(const BundleResult& result, Refinement* refinement);

// Estimates what `refinement` has taken once more, all of it together, from
// where it is. `detections` are those of the first round with the clocks set
// right (WithClocks), `matches` theirs with the refined cameras. Decisions
// stay.
void RefineAgain(const CameraRig& cameras, const DetectionSequence& detections,
                 const FrozenMatches& matches, const RefineOptions& options,
                 const BundleOptions& bundle, Refinement* refinement);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_REFINE_AGAIN_H_
