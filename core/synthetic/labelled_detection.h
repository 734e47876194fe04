// What the observers of a view share.
#ifndef KINEGRAPH_CORE_SYNTHETIC_LABELLED_DETECTION_H_
#define KINEGRAPH_CORE_SYNTHETIC_LABELLED_DETECTION_H_

#include <cstdint>

#include "core/data/detection.h"
#include "core/synthetic/noise.h"

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

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_LABELLED_DETECTION_H_
