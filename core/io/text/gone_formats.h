// Formats that are no longer supported for reading or writing, and
// alternatives.
#ifndef KINEGRAPH_CORE_IO_TEXT_GONE_FORMATS_H_
#define KINEGRAPH_CORE_IO_TEXT_GONE_FORMATS_H_

#include <string>
#include <string_view>

namespace kinegraph {

// Text to add to a message about a format of that name; empty for others.
inline std::string WayOnFrom(std::string_view format) {
  if (format == "coco3d") {
    return "; coco3d was removed: use csv, npz or JSON Lines, to which earlier "
           "versions convert it";
  }
  if (format == "poses") {
    return "; poses can only be read: write csv, npz or JSON Lines";
  }
  if (format == "smap") {
    return "; smap was removed: read it with a program of your own that prints "
           "JSON Lines, --adapter=PROGRAM (docs/adapters.md)";
  }
  return "";
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_GONE_FORMATS_H_
