#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/configuration/config.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

// `begin`, the parts separated by commas, and `end`.
std::string Joined(const std::string& begin,
                   const std::vector<std::string>& parts,
                   const std::string& end) {
  return begin + fmt::format("{}", fmt::join(parts, ", ")) + end;
}

// A value in TOML syntax. The keys in tables of texts (TextMap) are quoted, as
// they may be any names.
std::string TomlText(const Json& value) {
  // The escape sequences that JsonText writes are valid in TOML's basic
  // strings.
  if (value.is_string()) return JsonText(value.get<std::string>());
  if (value.is_number_float()) return fmt::format("{}", value.get<double>());
  if (!value.is_structured()) return value.dump();
  if (value.empty()) return value.is_array() ? "[]" : "{}";
  std::vector<std::string> parts;
  for (const auto& [name, part] : value.items()) {
    const std::string before = value.is_array()   ? ""
                               : part.is_string() ? TomlText(name) + " = "
                                                  : name + " = ";
    parts.push_back(before + TomlText(part));
  }
  return value.is_array() ? Joined("[", parts, "]") : Joined("{ ", parts, " }");
}

// Lists the keys, and collects their values as nested objects.
class KeyLister : public OptionVisitor {
 public:
  std::vector<ConfigKey> keys;
  Json root = Json::object();

  void Enter(const std::string& name) override { tables_.push_back(name); }
  void Leave() override { tables_.pop_back(); }
  void Number(const std::string& key, double* value, const Limits& limits,
              const std::string& unit, const std::string& help) override {
    Add(key, *value, unit, limits.ToString(), help);
  }
  void Integer(const std::string& key, int64_t* value, const Limits& limits,
               const std::string& unit, const std::string& help) override {
    Add(key, *value, unit, limits.ToString() + ", whole", help);
  }
  void Boolean(const std::string& key, bool* value,
               const std::string& help) override {
    Add(key, *value, "", "true, false", help);
  }
  void Text(const std::string& key, std::string* value,
            const std::string& help) override {
    Add(key, *value, "", "text", help);
  }
  void TextList(const std::string& key, std::vector<std::string>* value,
                const std::string& help) override {
    Add(key, *value, "", "list of texts", help);
  }
  void NumberList(const std::string& key, std::vector<double>* value,
                  const Limits& limits, const std::string& unit,
                  const std::string& help) override {
    Add(key, *value, unit, "list, each " + limits.ToString(), help);
  }
  void NumberTable(const std::string& key, double* values,
                   const std::vector<std::string>& names, const Limits& limits,
                   const std::string& unit, const std::string& help) override {
    Json written = *values;  // the common value, if all are equal
    if (std::any_of(values, values + names.size(),
                    [&](double value) { return value != *values; })) {
      written = Json::object();
      for (size_t i = 0; i < names.size(); ++i) written[names[i]] = values[i];
    }
    Add(key, written, unit,
        Joined(limits.ToString() + ", for all or by ", names, ""), help);
  }
  void TextMap(const std::string& key,
               std::map<std::string, std::string>* value,
               const std::string& help) override {
    Add(key, *value, "", "table of texts", help);
  }
  void ChoiceIndex(const std::string& key, int* value,
                   const std::vector<std::string>& names,
                   const std::string& help) override {
    std::vector<std::string> allowed;
    for (const std::string& name : names) allowed.push_back(TomlText(name));
    Add(key, names.at(static_cast<size_t>(*value)), "", Joined("", allowed, ""),
        help);
  }

 private:
  void Add(const std::string& key, const Json& value, const std::string& unit,
           const std::string& allowed, const std::string& help) {
    keys.push_back({fmt::format("{}", fmt::join(tables_, ".")), key,
                    TomlText(value), unit, allowed, help});
    Json* table = &root;
    for (const std::string& name : tables_) {
      table = &(*table)[name];
      if (table->is_null()) *table = Json::object();
    }
    (*table)[key] = value;
  }

  std::vector<std::string> tables_;
};

// A text for a cell of a Markdown table: escapes "|", which would end the cell,
// and replaces line ends by spaces.
std::string Cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c == '\n' ? ' ' : c;
  }
  return cell;
}

}  // namespace

std::string ConfigJson(const DescribeOptions& describe) {
  KeyLister lister;
  describe(lister);
  return DumpJson(lister.root);
}

std::vector<ConfigKey> ListKeys(const DescribeOptions& describe) {
  KeyLister lister;
  describe(lister);
  return std::move(lister.keys);
}

std::string KeyTable(const std::vector<ConfigKey>& keys) {
  std::string table =
      "| key | default | unit | allowed | meaning |\n|---|---|---|---|---|\n";
  for (const ConfigKey& key : keys) {
    table += fmt::format("| `{}` | `{}` | {} | {} | {} |\n", key.path(),
                         Cell(key.value), Cell(key.unit), Cell(key.allowed),
                         Cell(key.help));
  }
  return table;
}

}  // namespace kinegraph
