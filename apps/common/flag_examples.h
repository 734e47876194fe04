// What --help shows beside each flag: one example of its use.
#ifndef KINEGRAPH_APPS_COMMON_FLAG_EXAMPLES_H_
#define KINEGRAPH_APPS_COMMON_FLAG_EXAMPLES_H_

#include <set>
#include <string>

namespace kinegraph {

// "--cameras=calibration.json". Flags of one name mean the same in every
// command, but for those with an example of the command's own.
std::string FlagExample(const std::string& command, const std::string& flag,
                        const std::string& type,
                        const std::string& default_value);

// Flags that a usage such as "--cameras=F [--mode=M] --out=F" has outside of
// brackets, in its first form where there are several.
std::set<std::string> RequiredFlags(const std::string& usage);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_FLAG_EXAMPLES_H_
