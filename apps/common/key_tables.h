// The keys of a configuration, those of every day before those of experts.
#ifndef KINEGRAPH_APPS_COMMON_KEY_TABLES_H_
#define KINEGRAPH_APPS_COMMON_KEY_TABLES_H_

#include <string>

namespace kinegraph {

// Markdown of two headings with a table each, from the one table that
// ConfigReference makes. Throws std::logic_error where an everyday key is not
// in it.
std::string KeyTables(const std::string& reference);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_KEY_TABLES_H_
