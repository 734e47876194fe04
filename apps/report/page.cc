#include "apps/report/page.h"

#include <glog/logging.h>

#include <utility>
#include <vector>

#include "apps/report/assets.h"
#include "apps/report/encoding.h"
#include "core/io/files/write_text_file.h"

namespace kinegraph {

// Walks the template once, so that nothing inserted is read as a place again.
std::string MakePage(const std::string& title, const std::string& data_json) {
  const std::vector<std::pair<std::string, std::string>> places = {
      {"{{TITLE}}", HtmlText(title)},
      {"{{STYLE}}", assets::kPageCss},
      {"{{DATA}}", data_json},
      {"{{THREE}}", assets::kThreeJs},
      {"{{ORBIT_CONTROLS}}", assets::kOrbitControlsJs},
      {"{{SCRIPT}}", assets::kPageJs}};
  const std::string page = assets::kPageHtml;
  std::string html;
  size_t done = 0;
  for (const auto& [place, content] : places) {
    const size_t at = page.find(place, done);
    CHECK_NE(at, std::string::npos) << place << " is missing in page.html";
    html.append(page, done, at - done);
    html += content;
    done = at + place.size();
  }
  html.append(page, done);
  return html;
}

size_t WritePage(const std::string& title, const std::string& data_json,
                 const std::string& path) {
  const std::string page = MakePage(title, data_json);
  WriteTextFile(path, page);
  return page.size();
}

}  // namespace kinegraph
