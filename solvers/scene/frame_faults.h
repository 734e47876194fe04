// What the detections' own frames tell, without any calibration.
#ifndef KINEGRAPH_SOLVERS_SCENE_FRAME_FAULTS_H_
#define KINEGRAPH_SOLVERS_SCENE_FRAME_FAULTS_H_

#include <vector>

#include "solvers/scene/doctor.h"

namespace kinegraph {

// Frames too far apart to follow anybody, and pictures that come twice.
std::vector<Finding> FindFrameFaults(const DoctorInput& input);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SCENE_FRAME_FAULTS_H_
