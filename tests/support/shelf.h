// The real Shelf take with what its held-out cameras are scored by.
#ifndef KINEGRAPH_TESTS_SUPPORT_SHELF_H_
#define KINEGRAPH_TESTS_SUPPORT_SHELF_H_

#include <string>

#include "core/data/detection.h"
#include "core/data/held_out.h"
#include "core/data/pose.h"
#include "core/evaluation/held_out.h"
#include "core/geometry/camera.h"
#include "solvers/session/run.h"

namespace kinegraph::testing {

struct ShelfRecording {
  DetectionSequence detections;  // OpenPose as it is
  CameraRig cameras;             // in the order of the views
  TrackSequence truth;
  HeldOutSet set;
  TrackSequence reference;  // names the people of the set
};

// Throws InputError naming what is missing below `data_folder`.
ShelfRecording LoadRawShelf(const std::string& data_folder);

// Tracks with all cameras.
TrackSequence Track(const ShelfRecording& recording, const RunOptions& options);

// Tracks once without each camera and scores what that camera saw.
HeldOutScores ScoreHeldOutCameras(const ShelfRecording& recording,
                                  const RunOptions& options);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_SHELF_H_
