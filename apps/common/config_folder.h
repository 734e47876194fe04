// Configurations as commands find them, and their keys as pages and files show
// them.
#ifndef KINEGRAPH_APPS_COMMON_CONFIG_FOLDER_H_
#define KINEGRAPH_APPS_COMMON_CONFIG_FOLDER_H_

#include <string>
#include <vector>

#include "core/io/configuration/config.h"

namespace kinegraph {

struct RunOptions;

// Path of configs/`name` ("paper/shelf.toml"): beside an installed program
// (../share/kinegraph/configs) or above one in the build folder. Throws
// InputError when it is in none of these places.
std::string ProjectConfig(const std::string& name);

// A configuration as a user names it: a file, or from anywhere one of the
// project's, with or without "configs/" in front ("paper/shelf.toml"). Throws
// InputError that lists the project's where it is neither.
std::string FindConfig(const std::string& path);

// The options of a command: the configuration that --config names, without one
// configs/default.toml, with --set and --mode. Throws InputError or
// OptionError.
RunOptions OptionsOfFlags(const std::string& config, const std::string& set,
                          const std::string& mode);

// configs/default.toml with what flags of a command state: --frame_rate (0: not
// given), --skeleton of the detections, --set. Throws InputError or
// OptionError.
RunOptions DefaultOptions(double frame_rate_hz, const std::string& skeleton,
                          std::string set);

// Two lists of --set after one another; either may be empty.
std::string JoinSets(const std::string& first, const std::string& second);

// How one types the commands: "kinegraph" where it lies beside this program,
// else "./kinegraph", the driver of the sources.
std::string DriverName();

// Markdown of two headings with a table each: the keys of every day, and the
// others. Throws std::logic_error where a key of every day is missing.
std::string KeyTables(const std::vector<ConfigKey>& keys);

// A commented configuration of what `given` says: the keys of every day, those
// at their usual values as comments, and every other key with another value.
// Both lists hold the same keys in the same order.
std::string CommentedConfig(const std::vector<ConfigKey>& given,
                            const std::vector<ConfigKey>& usual);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_CONFIG_FOLDER_H_
