#include "apps/report/page.h"

#include <glog/logging.h>

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/text.h"
#include "core/io/files/atomic_file.h"

namespace kinegraph {
namespace {

using Keys = std::initializer_list<const char*>;

void ExpectNumbers(const JsonField& object, Keys keys) {
  for (const char* key : keys) object.At(key).Number();
}

void ExpectTexts(const JsonField& object, Keys keys) {
  for (const char* key : keys) object.At(key).Text();
}

// Optional values: the page omits the line if there is none.
void ExpectNumberIfAny(const JsonField& object, const char* key) {
  const std::optional<JsonField> field = object.Find(key);
  if (field.has_value() && !field->value().is_null()) field->Number();
}

void CheckNoise(const JsonField& noise) {
  ExpectNumberIfAny(noise, "error_time_s");
  ExpectNumberIfAny(noise, "confidence_power");
  const std::optional<JsonField> classes = noise.Find("classes");
  if (!classes.has_value()) return;
  for (const JsonField::Member& one : classes->Members("class")) {
    ExpectNumbers(one.field, {"sigma_px", "process_noise"});
  }
}

}  // namespace

// Scans the template once, so that inserted text is never treated as a
// placeholder.
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

std::string WithoutAngleBrackets(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    safe += c == '<' ? "\\u003c" : std::string_view(&c, 1);
  }
  return safe;
}

namespace {

// The value of a dotted key such as "cameras.refine"; null if absent.
Json ValueOf(const Json& config, const std::string& dotted) {
  const Json* value = &config;
  for (const std::string& key : Split(dotted, '.')) {
    if (!value->contains(key)) return Json();
    value = &value->at(key);
  }
  return *value;
}

// Whether the configuration already has every key=value of a fix that is a
// single --set, quoted or not. False for other fixes.
bool IsSet(const std::string& fix, const Json& config) {
  const size_t quotes = fix.rfind("'", 0) == 0 ? 1 : 0;
  const std::string flag = "--set=";
  if (fix.size() < flag.size() + 2 * quotes ||
      fix.compare(quotes, flag.size(), flag) != 0) {
    return false;
  }
  const std::string keys =
      fix.substr(quotes + flag.size(), fix.size() - flag.size() - 2 * quotes);
  for (const std::string& part : Split(keys, ';')) {
    const size_t equals = part.find('=');
    if (equals == std::string::npos) return false;
    const Json value = ValueOf(config, part.substr(0, equals));
    const std::string wanted = part.substr(equals + 1);
    if (value.is_null()) return false;
    if ((value.is_string() ? value.get<std::string>() : value.dump()) !=
        wanted) {
      return false;
    }
  }
  return true;
}

// Whether cameras.refine or cameras.refine_clock corrects a finding of this
// kind.
bool IsRefined(const std::string& kind, const Json& config) {
  if (kind == "clock_offset" || kind == "clock_drift") {
    return ValueOf(config, "cameras.refine_clock") == true;
  }
  const Json refine = ValueOf(config, "cameras.refine");
  // Poses do not include the principal point.
  if (kind == "shift") return refine == "shift";
  if (kind == "focal_length") return refine == "pose_focal";
  return kind == "rotation" &&
         (refine == "rotation" || refine == "pose" || refine == "pose_focal");
}

}  // namespace

void LeaveOutMended(const std::string& config_json, Json* doctor) {
  const Json config = Json::parse(config_json, nullptr, false);
  if (!config.is_object()) return;
  Json left = Json::array();
  bool mended = false;
  for (const Json& finding : doctor->at("findings")) {
    if (IsSet(finding.at("fix").get<std::string>(), config) ||
        IsRefined(finding.at("kind").get<std::string>(), config)) {
      mended = true;
    } else {
      left.push_back(finding);
    }
  }
  (*doctor)["findings"] = std::move(left);
  if (mended) (*doctor)["mended"] = true;
}

Json ReadSummaryJson(const std::string& text, const std::string& file) {
  Json json = ParseJson(text, file);
  const JsonField root(json, file);
  for (const JsonField& camera : root.At("cameras").Elements("camera")) {
    ExpectTexts(camera, {"view"});
    ExpectNumbers(camera, {"matched_share", "median_px", "p90_px"});
  }
  for (const JsonField& person : root.At("people").Elements("person")) {
    ExpectNumbers(person, {"frames"});
    ExpectNumberIfAny(person, "height_m");
  }
  ExpectNumbers(root, {"most_people_in_a_view"});
  for (const JsonField& warning : root.At("warnings").Elements("warning")) {
    ExpectTexts(warning, {"text", "try"});
  }
  if (const auto solver = root.Find("solver")) {
    ExpectTexts(*solver, {"name"});
    ExpectNumbers(*solver, {"solves", "not_converged", "failed"});
  }
  if (const auto noise = root.Find("noise")) CheckNoise(*noise);
  return json;
}

Json ReadDoctorJson(const std::string& text, const std::string& file) {
  Json json = ParseJson(text, file);
  const JsonField root(json, file);
  ExpectTexts(root, {"verdict"});
  for (const JsonField& finding : root.At("findings").Elements("finding")) {
    ExpectTexts(finding, {"kind", "fix"});
    ExpectNumbers(finding, {"confidence"});
    ExpectNumberIfAny(finding, "before_px");
    ExpectNumberIfAny(finding, "after_px");
    for (const char* key : {"camera", "evidence"}) {
      const std::optional<JsonField> field = finding.Find(key);
      if (field.has_value() && !field->value().is_null()) field->Text();
    }
  }
  return json;
}

}  // namespace kinegraph
