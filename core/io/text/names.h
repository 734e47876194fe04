// Numbers in the names of files, folders and views.
#ifndef KINEGRAPH_CORE_IO_TEXT_NAMES_H_
#define KINEGRAPH_CORE_IO_TEXT_NAMES_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kinegraph {

// The last run of digits; nullopt if there is none or it has more than 18
// digits, not counting leading zeros.
std::optional<int64_t> LastInteger(std::string_view name);

// Frame number in the name of a detection file: the last integer before
// "_keypoints", or before the extension if there is no "_keypoints". nullopt as
// for LastInteger.
std::optional<int64_t> FrameOfFileName(std::string_view file_name);

// The same, but throws InputError (which names only `file_name`) if there is no
// number, or if the number looks like a time or a date (as every number from
// kMostFrames does). Also for names of images.
int64_t FrameOfName(std::string_view file_name);

// FrameOfName and, with a rate, TimeOfFrame (bulk_json.h) require frame numbers
// below this: 30 years at 1000 Hz. Milliseconds since 1970 exceed it for all
// dates after September 2001.
inline constexpr int64_t kMostFrames = 1'000'000'000'000;
// The remedy, for messages about such numbers.
inline constexpr const char* kNumberByTime =
    "; number the frames of all views by (time - first time) x frame rate, "
    "rounded";

// Natural order, in which "cam2" comes before "cam10".
bool NaturalLess(std::string_view a, std::string_view b);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_NAMES_H_
