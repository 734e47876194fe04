#include "core/io/toml_file.h"

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace kinegraph {
namespace {

Json TableToJson(const toml::table& table) {
  std::vector<std::pair<toml::source_position, const toml::key*>> order;
  for (const auto& [key, value] : table) {
    order.emplace_back(value.source().begin, &key);
  }
  std::stable_sort(
      order.begin(), order.end(),
      [](const auto& a, const auto& b) { return a.first < b.first; });
  Json object = Json::object();
  for (const auto& entry : order) {
    const std::string key(entry.second->str());
    object[key] = ToJson(*table.get(key));
  }
  return object;
}

}  // namespace

toml::table ParseToml(const std::string& text, const std::string& file) {
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw InputError(file + ":" + std::to_string(error.source().begin.line), "",
                     "is not TOML: " + std::string(error.description()));
  }
}

Json ToJson(const toml::node& node) {
  if (const toml::table* table = node.as_table()) return TableToJson(*table);
  if (const toml::array* array = node.as_array()) {
    Json values = Json::array();
    for (const toml::node& value : *array) values.push_back(ToJson(value));
    return values;
  }
  if (const auto* text = node.as_string()) return Json(text->get());
  if (const auto* integer = node.as_integer()) return Json(integer->get());
  if (const auto* number = node.as_floating_point()) return Json(number->get());
  if (const auto* boolean = node.as_boolean()) return Json(boolean->get());
  std::ostringstream other;  // dates and times: as the file writes them
  node.visit([&other](const auto& value) { other << value; });
  return Json(other.str());
}

}  // namespace kinegraph
