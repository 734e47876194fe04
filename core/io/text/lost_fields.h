// What a format cannot store, as reported by its writer, and other remarks on a
// conversion.
#ifndef KINEGRAPH_CORE_IO_TEXT_LOST_FIELDS_H_
#define KINEGRAPH_CORE_IO_TEXT_LOST_FIELDS_H_

#include <string>
#include <vector>

namespace kinegraph {

// One short line each, without a full stop: "image sizes are not kept".
using LostFields = std::vector<std::string>;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_LOST_FIELDS_H_
