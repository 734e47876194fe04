// The page itself: markup, style, scripts and data in one file.
#ifndef KINEGRAPH_APPS_REPORT_PAGE_H_
#define KINEGRAPH_APPS_REPORT_PAGE_H_

#include <cstddef>
#include <string>

namespace kinegraph {

// `data_json` as MakePageData gives it.
std::string MakePage(const std::string& title, const std::string& data_json);

// Writes it to a file, aside first. Returns its size in bytes; throws
// InputError when the file cannot be written.
size_t WritePage(const std::string& title, const std::string& data_json,
                 const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_PAGE_H_
