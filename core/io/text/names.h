// Numbers in the names of files, folders and views.
#ifndef KINEGRAPH_CORE_IO_TEXT_NAMES_H_
#define KINEGRAPH_CORE_IO_TEXT_NAMES_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kinegraph {

// The last run of digits; nullopt if there is none or it is longer than any
// frame number (18 digits, not counting leading zeros).
std::optional<int64_t> LastInteger(std::string_view name);

// Frame number of a detection file: the last integer before "_keypoints", else
// before the extension.
std::optional<int64_t> FrameOfFileName(std::string_view file_name);

// The same, also for an image's name. Throws InputError without a file name if
// there is none, or if the number is a time or a date.
int64_t FrameOfName(std::string_view file_name);

// Order in which "cam2" comes before "cam10".
bool NaturalLess(std::string_view a, std::string_view b);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_NAMES_H_
