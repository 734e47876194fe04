// Locates configurations for commands, and formats their keys for pages and
// files.
#ifndef KINEGRAPH_APPS_COMMON_CONFIG_FOLDER_H_
#define KINEGRAPH_APPS_COMMON_CONFIG_FOLDER_H_

#include <string>
#include <vector>

#include "core/io/configuration/config.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

struct RunOptions;

// Path of configs/`name` ("paper/shelf.toml"): beside an installed program
// (../share/kinegraph/configs) or above one in the build folder. Throws
// InputError if it is in neither place.
std::string ProjectConfig(const std::string& name);

// Path of the shipped configuration with that name, with or without "configs/";
// empty if there is none.
std::string ShippedConfig(const std::string& name);

// Path of the configuration that a user names: an existing path, else one of
// the project's configurations, with or without "configs/" in front
// ("paper/shelf.toml"). If neither exists, throws InputError, which lists the
// project's configurations for tracking and for synthetic scenes. Empty and
// absolute paths are returned unchecked.
std::string FindConfig(const std::string& path);

// The options of a command: the configuration of --config, by default
// configs/default.toml, with --set and --mode. Throws InputError or
// OptionError.
RunOptions OptionsOfFlags(const std::string& config, const std::string& set,
                          const std::string& mode);

// configs/default.toml with the values of a command's flags: --frame_rate (0:
// not given), --skeleton of the detections, --set. Throws InputError or
// OptionError.
RunOptions DefaultOptions(double frame_rate_hz, const std::string& skeleton,
                          std::string set);

// Concatenates two lists of --set; either may be empty.
std::string JoinSets(const std::string& first, const std::string& second);

// The script `kinegraph` as command lines in messages spell it: "kinegraph" if
// it is in this program's folder, else "./kinegraph" of the source tree.
std::string DriverName();

// Markdown with two tables under headings: the everyday keys, and all others.
// Throws std::logic_error if an everyday key is missing.
std::string KeyTables(const std::vector<ConfigKey>& keys);

// A commented configuration with the values of `given`: the everyday keys,
// commented out at their default, and every other key that differs from its
// default. `usual` has the defaults: the same keys in the same order.
std::string CommentedConfig(const std::vector<ConfigKey>& given,
                            const std::vector<ConfigKey>& usual);

// The tables [skeletons.NAME] of a configuration, after all other keys.
std::string SkeletonTables(const std::vector<Skeleton>& skeletons);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_CONFIG_FOLDER_H_
