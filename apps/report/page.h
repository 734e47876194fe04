// The page itself: markup, style, scripts and data in one file.
#ifndef KINEGRAPH_APPS_REPORT_PAGE_H_
#define KINEGRAPH_APPS_REPORT_PAGE_H_

#include <string>

namespace kinegraph {

// `data_json` as MakePageData gives it.
std::string MakePage(const std::string& title, const std::string& data_json);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_PAGE_H_
