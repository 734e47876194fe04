#include "apps/report/side_files.h"

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>

namespace kinegraph {
namespace {

using Keys = std::initializer_list<const char*>;

void ExpectNumbers(const JsonField& object, Keys keys) {
  for (const char* key : keys) object.At(key).Number();
}

void ExpectTexts(const JsonField& object, Keys keys) {
  for (const char* key : keys) object.At(key).Text();
}

// Where there is no value, the page leaves its line out.
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
