// People whose motion a simulation made up.
#ifndef KINEGRAPH_CORE_SYNTHETIC_SIMULATED_PEOPLE_H_
#define KINEGRAPH_CORE_SYNTHETIC_SIMULATED_PEOPLE_H_

#include <memory>
#include <vector>

#include "core/skeleton/skeleton.h"
#include "core/synthetic/actor.h"
#include "core/synthetic/scene.h"

namespace kinegraph {

// They walk, swing their arms, sit and gesture. Throws OptionError("skeleton",
// ...) for joints that a body does not have.
std::vector<std::shared_ptr<const Actor>> SimulatePeople(
    const SceneOptions& options, const Skeleton& skeleton);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_SIMULATED_PEOPLE_H_
