// Parsing TOML, with kinegraph's error messages. For the readers of core/io
// only.
#ifndef KINEGRAPH_CORE_IO_TEXT_TOML_FILE_H_
#define KINEGRAPH_CORE_IO_TEXT_TOML_FILE_H_

#include <toml++/toml.h>

#include <string>

#include "core/io/text/json.h"

namespace kinegraph {

// Throws InputError naming `file` and line for a syntax error, a duplicate key,
// too deep nesting or too many values.
toml::table ParseToml(const std::string& text, const std::string& file);

// The same values as JSON, with tables in file order (toml++ sorts them by
// name).
Json ToJson(const toml::node& node);

// The content of a file. Throws InputError naming it.
Json ReadToml(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_TOML_FILE_H_
