// The fixed set of detections on which held-out-camera errors are computed.
#ifndef KINEGRAPH_CORE_DATA_HELD_OUT_H_
#define KINEGRAPH_CORE_DATA_HELD_OUT_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/ids.h"

namespace kinegraph {

struct HeldOutDetection {
  int64_t frame = 0;
  std::string view_name;
  int detection_idx = 0;  // index_in_file
  TrackId person;         // of the reference tracks
};

struct HeldOutSet {
  double min_confidence = 0.3;  // of joints that are scored
  // Limit of a joint's error, and the error of a joint without prediction.
  double cap_px = 100.0;
  // Greatest mean joint distance at which a person of a run is paired with one
  // of the reference tracks.
  double pairing_gate_m = 0.5;
  std::vector<HeldOutDetection> detections;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_HELD_OUT_H_
