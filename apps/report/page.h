// Writes the page: markup, style, scripts and data in one file. Encodes bytes
// and numbers for it, and checks the JSON files of other commands.
#ifndef KINEGRAPH_APPS_REPORT_PAGE_H_
#define KINEGRAPH_APPS_REPORT_PAGE_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/text.h"
#include "core/io/text/json.h"

namespace kinegraph {

// Makes the page; `data_json` comes from MakePageData.
std::string MakePage(const std::string& title, const std::string& data_json);

// Writes the page to a file atomically. Returns its size in bytes; throws
// InputError if the file cannot be written.
size_t WritePage(const std::string& title, const std::string& data_json,
                 const std::string& path);

// Encodes the bytes of the numbers as they are in memory. Pages read them as
// little-endian, the byte order of every supported machine.
template <typename Number>
std::string Base64(const std::vector<Number>& numbers) {
  return Base64(std::string_view(reinterpret_cast<const char*>(numbers.data()),
                                 numbers.size() * sizeof(Number)));
}

// `value` in units of `quantum`, rounded and clamped to the range of the type.
template <typename Integer>
Integer Quantise(double value, double quantum) {
  const double scaled = std::round(value / quantum);
  const double low = std::numeric_limits<Integer>::min();
  const double high = std::numeric_limits<Integer>::max();
  return static_cast<Integer>(std::clamp(scaled, low, high));
}

// JSON text without "<", so that no tag or comment can begin or end in it.
std::string WithoutAngleBrackets(const std::string& json);

// The files of other commands that the page displays: NAME.summary.json, which
// `track` writes beside the tracks, and doctor.json of `doctor`. They are
// validated, because the page's scripts do not check their data. Both throw
// InputError naming `file` and the invalid key.
Json ReadSummaryJson(const std::string& text, const std::string& file);
Json ReadDoctorJson(const std::string& text, const std::string& file);

// Removes findings of the doctor that the configuration of a result already
// corrects: it sets the keys of the fix, or refines the parameter concerned.
// Sets "mended" to true if any finding is removed.
void LeaveOutMended(const std::string& config_json, Json* doctor);

// The page's sources, embedded into the program by embed.cmake.
namespace assets {

extern const char* const kPageHtml;
extern const char* const kPageCss;
extern const char* const kPageJs;
extern const char* const kThreeJs;
extern const char* const kOrbitControlsJs;

}  // namespace assets

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_PAGE_H_
