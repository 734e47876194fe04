// What checkpoints keep, as bytes; and what their keys are made of.
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_CHECKPOINT_VALUES_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_CHECKPOINT_VALUES_H_

#include <vector>

#include "core/base/bytes.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// Every bit comes back.
void Put(const PersonPose& person, ByteWriter* writer);
PersonPose GetPersonPose(ByteReader* reader);
void Put(const std::vector<TrackFrame>& frames, ByteWriter* writer);
std::vector<TrackFrame> GetTrackFrames(ByteReader* reader);

// For keys alone: there is no way back.
void Put(const Skeleton& skeleton, ByteWriter* writer);
void Put(const CameraRig& cameras, ByteWriter* writer);
void Put(const Keypoint& joint, ByteWriter* writer);
std::string ContentOf(const DetectionSequence& detections);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_CHECKPOINT_VALUES_H_
