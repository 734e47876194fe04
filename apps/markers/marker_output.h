// What a study against markers found, for people and for scripts.
#ifndef KINEGRAPH_APPS_MARKERS_MARKER_OUTPUT_H_
#define KINEGRAPH_APPS_MARKERS_MARKER_OUTPUT_H_

#include <string>

#include "apps/markers/marker_study.h"
#include "core/io/text/json.h"

namespace kinegraph {

// Millimetres, degrees and seconds as the keys say; null where there is none.
Json MarkerJson(const MarkerStudy& study);
std::string MarkerMarkdown(const MarkerStudy& study);
// markers.json, markers.md, plots and page.html into a new folder.
void WriteMarkerFolder(const MarkerStudy& study, const Json& json,
                       const std::string& folder);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_MARKERS_MARKER_OUTPUT_H_
