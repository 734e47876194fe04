// The keys of a configuration as pages and files show them.
#ifndef KINEGRAPH_APPS_COMMON_KEY_TABLES_H_
#define KINEGRAPH_APPS_COMMON_KEY_TABLES_H_

#include <string>
#include <vector>

#include "core/io/configuration/config.h"

namespace kinegraph {

// Markdown of two headings with a table each: the keys of every day, and the
// others. Throws std::logic_error where a key of every day is missing.
std::string KeyTables(const std::vector<ConfigKey>& keys);

// A commented configuration of what `given` says: the keys of every day, those
// at their usual values as comments, and every other key with another value.
// Both lists hold the same keys in the same order.
std::string CommentedConfig(const std::vector<ConfigKey>& given,
                            const std::vector<ConfigKey>& usual);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_KEY_TABLES_H_
