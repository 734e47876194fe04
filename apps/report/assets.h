// The page's sources, put into the program by embed.cmake.
#ifndef KINEGRAPH_APPS_REPORT_ASSETS_H_
#define KINEGRAPH_APPS_REPORT_ASSETS_H_

namespace kinegraph::assets {

extern const char* const kPageHtml;
extern const char* const kPageCss;
extern const char* const kPageJs;
extern const char* const kThreeJs;
extern const char* const kOrbitControlsJs;

}  // namespace kinegraph::assets

#endif  // KINEGRAPH_APPS_REPORT_ASSETS_H_
