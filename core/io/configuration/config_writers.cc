#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/configuration/config.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

bool AllAlike(const double* values, size_t count) {
  return std::all_of(values, values + count,
                     [&](double value) { return value == *values; });
}

// ---- Effective values as JSON ----

class JsonWriter : public OptionVisitor {
 public:
  std::string ToString() const { return DumpJson(root_); }

  void Enter(const std::string& name) override { tables_.push_back(name); }
  void Leave() override { tables_.pop_back(); }
  void Number(const std::string& key, double* value, const Limits&,
              const std::string&, const std::string&) override {
    Table()[key] = *value;
  }
  void Integer(const std::string& key, int64_t* value, const Limits&,
               const std::string&, const std::string&) override {
    Table()[key] = *value;
  }
  void Boolean(const std::string& key, bool* value,
               const std::string&) override {
    Table()[key] = *value;
  }
  void Text(const std::string& key, std::string* value,
            const std::string&) override {
    Table()[key] = *value;
  }
  void TextList(const std::string& key, std::vector<std::string>* value,
                const std::string&) override {
    Table()[key] = *value;
  }
  void NumberList(const std::string& key, std::vector<double>* value,
                  const Limits&, const std::string&,
                  const std::string&) override {
    Table()[key] = *value;
  }
  void NumberTable(const std::string& key, double* values,
                   const std::vector<std::string>& names, const Limits&,
                   const std::string&, const std::string&) override {
    Json& written = Table()[key];
    if (AllAlike(values, names.size())) {
      written = *values;
      return;
    }
    for (const std::string& name : names) written[name] = *values++;
  }
  void TextMap(const std::string& key,
               std::map<std::string, std::string>* value,
               const std::string&) override {
    Table()[key] = Json(*value);
  }
  void ChoiceIndex(const std::string& key, int* value,
                   const std::vector<std::string>& names,
                   const std::string&) override {
    Table()[key] = names.at(static_cast<size_t>(*value));
  }

 private:
  // The object of the open table; made when the first key is written.
  Json& Table() {
    Json* table = &root_;
    for (const std::string& name : tables_) {
      table = &(*table)[name];
      if (table->is_null()) *table = Json::object();
    }
    return *table;
  }

  Json root_ = Json::object();
  std::vector<std::string> tables_;
};

// ---- The keys for readers ----

std::string TomlNumber(double value) { return fmt::format("{}", value); }

std::string TomlText(const std::string& text) { return '"' + text + '"'; }

// The parts with a comma between them, between the ends.
std::string Joined(const std::string& begin,
                   const std::vector<std::string>& parts,
                   const std::string& end) {
  return begin + fmt::format("{}", fmt::join(parts, ", ")) + end;
}

class KeyLister : public OptionVisitor {
 public:
  std::vector<ConfigKey> keys;

  void Enter(const std::string& name) override { tables_.push_back(name); }
  void Leave() override { tables_.pop_back(); }
  void Number(const std::string& key, double* value, const Limits& limits,
              const std::string& unit, const std::string& help) override {
    Add(key, TomlNumber(*value), unit, limits.ToString(), help);
  }
  void Integer(const std::string& key, int64_t* value, const Limits& limits,
               const std::string& unit, const std::string& help) override {
    Add(key, std::to_string(*value), unit, limits.ToString() + ", whole", help);
  }
  void Boolean(const std::string& key, bool* value,
               const std::string& help) override {
    Add(key, *value ? "true" : "false", "", "true, false", help);
  }
  void Text(const std::string& key, std::string* value,
            const std::string& help) override {
    Add(key, TomlText(*value), "", "text", help);
  }
  void TextList(const std::string& key, std::vector<std::string>* value,
                const std::string& help) override {
    std::vector<std::string> texts;
    for (const std::string& text : *value) texts.push_back(TomlText(text));
    Add(key, Joined("[", texts, "]"), "", "list of texts", help);
  }
  void NumberList(const std::string& key, std::vector<double>* value,
                  const Limits& limits, const std::string& unit,
                  const std::string& help) override {
    std::vector<std::string> numbers;
    for (const double number : *value) numbers.push_back(TomlNumber(number));
    Add(key, Joined("[", numbers, "]"), unit, "list, each " + limits.ToString(),
        help);
  }
  void NumberTable(const std::string& key, double* values,
                   const std::vector<std::string>& names, const Limits& limits,
                   const std::string& unit, const std::string& help) override {
    std::vector<std::string> pairs;
    for (size_t i = 0; i < names.size(); ++i) {
      pairs.push_back(names[i] + " = " + TomlNumber(values[i]));
    }
    Add(key,
        AllAlike(values, names.size()) ? TomlNumber(*values)
                                       : Joined("{ ", pairs, " }"),
        unit,
        limits.ToString() + ", for all or by " +
            fmt::format("{}", fmt::join(names, ", ")),
        help);
  }
  void TextMap(const std::string& key,
               std::map<std::string, std::string>* value,
               const std::string& help) override {
    std::vector<std::string> pairs;
    for (const auto& [name, text] : *value) {
      pairs.push_back(TomlText(name) + " = " + TomlText(text));
    }
    Add(key, pairs.empty() ? "{}" : Joined("{ ", pairs, " }"), "",
        "table of texts", help);
  }
  void ChoiceIndex(const std::string& key, int* value,
                   const std::vector<std::string>& names,
                   const std::string& help) override {
    std::vector<std::string> allowed;
    for (const std::string& name : names) allowed.push_back(TomlText(name));
    Add(key, allowed.at(static_cast<size_t>(*value)), "",
        Joined("", allowed, ""), help);
  }

 private:
  void Add(const std::string& key, const std::string& value,
           const std::string& unit, const std::string& allowed,
           const std::string& help) {
    std::string table = JoinKey(tables_, "");
    if (!table.empty()) table.pop_back();  // the dot
    keys.push_back({table, key, value, unit, allowed, help});
  }

  std::vector<std::string> tables_;
};

// A text inside a cell: "|" would end it.
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
  JsonWriter writer;
  describe(writer);
  return writer.ToString();
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
