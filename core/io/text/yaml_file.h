// YAML as OpenCV's FileStorage writes it. For the readers of core/io alone.
#ifndef KINEGRAPH_CORE_IO_TEXT_YAML_FILE_H_
#define KINEGRAPH_CORE_IO_TEXT_YAML_FILE_H_

#include <string>

#include "core/io/text/json.h"

namespace kinegraph {

// The one document of a text as JSON. A map of rows, cols and data (OpenCV's
// !!opencv-matrix) becomes an array of rows. Unquoted scalars that are numbers
// become numbers, all others texts. Throws InputError naming `file` and line
// for a syntax error, a repeated key, deep nesting or more than 200,000
// values.
Json ParseYaml(const std::string& text, const std::string& file);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_YAML_FILE_H_
