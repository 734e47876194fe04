// One camera of a synthetic scene and its modelled detector.
#ifndef KINEGRAPH_CORE_SYNTHETIC_VIEW_OBSERVER_H_
#define KINEGRAPH_CORE_SYNTHETIC_VIEW_OBSERVER_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/synthetic/actor.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"

namespace kinegraph {

// A seed of its own for each kind of chance, view and person (or whatever the
// two numbers count), so that one does not disturb another.
enum class Stream {
  kPixels,
  kOutliers,
  kMissing,
  kConfidence,
  kPeople,
  kFalsePeople,
  kOrder,
  kFrames,
  kJitter
};
uint64_t StreamSeed(int64_t seed, Stream stream, int a, int b);

struct LabelledDetection {
  Detection detection;
  DetectionTruth truth;
};

// A person of the scene at one moment.
struct PersonMoment {
  Pose3d pose;  // empty: not there, and what follows says nothing
  SegmentPose trunk;
  std::optional<Obstacle> obstacle;  // where hiding matters
};
struct SceneMoment {
  TimeNs time = 0;
  std::vector<PersonMoment> people;
};

SceneMoment LookAtScene(const Scene& scene, TimeNs time, bool with_obstacles);

// What the detector of view `view_idx` finds, frame after frame. The references
// must outlive it.
using ViewObserver =
    std::function<std::vector<LabelledDetection>(const SceneMoment& moment)>;
ViewObserver ObserverOf(const NoiseOptions& options, const Scene& scene,
                        int view_idx);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_VIEW_OBSERVER_H_
