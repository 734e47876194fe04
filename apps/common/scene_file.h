// scene.json: what a synthetic recording was asked for, and what stands behind
// each of its detections.
#ifndef KINEGRAPH_APPS_COMMON_SCENE_FILE_H_
#define KINEGRAPH_APPS_COMMON_SCENE_FILE_H_

#include <string>

#include "apps/common/synthesis.h"

namespace kinegraph {

void WriteSceneFile(const std::string& path,
                    const SyntheticRecording& recording);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_SCENE_FILE_H_
