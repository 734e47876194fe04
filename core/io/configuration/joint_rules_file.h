// What a joint is among a laboratory's markers, as a user states it.
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_JOINT_RULES_FILE_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_JOINT_RULES_FILE_H_

#include <string>

#include "core/data/joint_rules.h"

namespace kinegraph {

// [joints.NAME] with one of `middle_of`, `marker`, `regression`, `functional`
// (docs/validate.md). Throws InputError naming file and key.
MarkerSet ReadJointRules(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_JOINT_RULES_FILE_H_
