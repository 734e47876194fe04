// The files beside tracks that the page shows, checked so that no script there
// meets what it does not expect.
#ifndef KINEGRAPH_APPS_REPORT_SIDE_FILES_H_
#define KINEGRAPH_APPS_REPORT_SIDE_FILES_H_

#include <string>

#include "core/io/text/json.h"

namespace kinegraph {

// NAME.summary.json of `track`, doctor.json of `doctor`. Both throw InputError
// naming `file` and the place for what is none.
Json ReadSummaryJson(const std::string& text, const std::string& file);
Json ReadDoctorJson(const std::string& text, const std::string& file);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_SIDE_FILES_H_
