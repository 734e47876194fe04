#include <fmt/format.h>

#include "core/io/configuration/config.h"
#include "core/io/text/json.h"

namespace kinegraph {

// ---- Effective values as JSON ----

class ConfigJsonWriter::Impl {
 public:
  // The object of the open table; made when the first key is written.
  Json& Table() {
    Json* table = &root;
    for (const std::string& name : tables) {
      table = &(*table)[name];
      if (table->is_null()) *table = Json::object();
    }
    return *table;
  }

  Json root = Json::object();
  std::vector<std::string> tables;
};

ConfigJsonWriter::ConfigJsonWriter() : impl_(std::make_unique<Impl>()) {}
ConfigJsonWriter::~ConfigJsonWriter() = default;

std::string ConfigJsonWriter::ToString() const { return DumpJson(impl_->root); }

void ConfigJsonWriter::Enter(const std::string& name) {
  impl_->tables.push_back(name);
}

void ConfigJsonWriter::Leave() { impl_->tables.pop_back(); }

void ConfigJsonWriter::Number(const std::string& key, double* value,
                              const Limits&, const std::string&,
                              const std::string&) {
  impl_->Table()[key] = *value;
}

void ConfigJsonWriter::Integer(const std::string& key, int64_t* value,
                               const Limits&, const std::string&,
                               const std::string&) {
  impl_->Table()[key] = *value;
}

void ConfigJsonWriter::Boolean(const std::string& key, bool* value,
                               const std::string&) {
  impl_->Table()[key] = *value;
}

void ConfigJsonWriter::Text(const std::string& key, std::string* value,
                            const std::string&) {
  impl_->Table()[key] = *value;
}

void ConfigJsonWriter::TextList(const std::string& key,
                                std::vector<std::string>* value,
                                const std::string&) {
  impl_->Table()[key] = *value;
}

void ConfigJsonWriter::NumberList(const std::string& key,
                                  std::vector<double>* value, const Limits&,
                                  const std::string&, const std::string&) {
  impl_->Table()[key] = *value;
}

void ConfigJsonWriter::TextMap(const std::string& key,
                               std::map<std::string, std::string>* value,
                               const std::string&) {
  impl_->Table()[key] = Json(*value);
}

void ConfigJsonWriter::ChoiceIndex(const std::string& key, int* value,
                                   const std::vector<std::string>& names,
                                   const std::string&) {
  impl_->Table()[key] = names.at(static_cast<size_t>(*value));
}

// ---- The keys as a Markdown table ----

namespace {

// A text inside a cell: "|" would end it.
std::string Cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c == '\n' ? ' ' : c;
  }
  return cell;
}

std::string Code(const std::string& text) { return "`" + text + "`"; }

// As TOML has it: `"text"`.
std::string CodeText(const std::string& text) { return Code('"' + text + '"'); }

template <typename Values, typename Format>
std::string CodeList(const Values& values, const Format& format) {
  std::string list;
  for (const auto& value : values) {
    list += (list.empty() ? "" : ", ") + format(value);
  }
  return Code("[" + list + "]");
}

}  // namespace

std::string ConfigReferenceWriter::ToString() const {
  return "| key | default | unit | allowed | meaning "
         "|\n|---|---|---|---|---|\n" +
         rows_;
}

void ConfigReferenceWriter::Row(const std::string& key,
                                const std::string& value,
                                const std::string& unit,
                                const std::string& allowed,
                                const std::string& help) {
  rows_ += "| " + Code(JoinKey(tables_, key)) + " | " + Cell(value) + " | " +
           Cell(unit) + " | " + Cell(allowed) + " | " + Cell(help) + " |\n";
}

void ConfigReferenceWriter::Enter(const std::string& name) {
  tables_.push_back(name);
}

void ConfigReferenceWriter::Leave() { tables_.pop_back(); }

void ConfigReferenceWriter::Number(const std::string& key, double* value,
                                   const Limits& limits,
                                   const std::string& unit,
                                   const std::string& help) {
  Row(key, Code(fmt::format("{}", *value)), unit, limits.ToString(), help);
}

void ConfigReferenceWriter::Integer(const std::string& key, int64_t* value,
                                    const Limits& limits,
                                    const std::string& unit,
                                    const std::string& help) {
  Row(key, Code(fmt::format("{}", *value)), unit, limits.ToString() + ", whole",
      help);
}

void ConfigReferenceWriter::Boolean(const std::string& key, bool* value,
                                    const std::string& help) {
  Row(key, Code(*value ? "true" : "false"), "", "`true`, `false`", help);
}

void ConfigReferenceWriter::Text(const std::string& key, std::string* value,
                                 const std::string& help) {
  Row(key, CodeText(*value), "", "text", help);
}

void ConfigReferenceWriter::TextList(const std::string& key,
                                     std::vector<std::string>* value,
                                     const std::string& help) {
  Row(key, CodeList(*value, [](const auto& text) { return '"' + text + '"'; }),
      "", "list of texts", help);
}

void ConfigReferenceWriter::NumberList(const std::string& key,
                                       std::vector<double>* value,
                                       const Limits& limits,
                                       const std::string& unit,
                                       const std::string& help) {
  Row(key,
      CodeList(*value, [](double number) { return fmt::format("{}", number); }),
      unit, "list, each " + limits.ToString(), help);
}

void ConfigReferenceWriter::TextMap(const std::string& key,
                                    std::map<std::string, std::string>* value,
                                    const std::string& help) {
  std::string pairs;
  for (const auto& [name, text] : *value) {
    pairs += (pairs.empty() ? "" : ", ") + name + " = \"" + text + '"';
  }
  Row(key, Code(pairs.empty() ? "{}" : "{ " + pairs + " }"), "",
      "table of texts", help);
}

void ConfigReferenceWriter::ChoiceIndex(const std::string& key, int* value,
                                        const std::vector<std::string>& names,
                                        const std::string& help) {
  std::string allowed;
  for (const std::string& name : names) {
    allowed += (allowed.empty() ? "" : ", ") + CodeText(name);
  }
  Row(key, CodeText(names.at(static_cast<size_t>(*value))), "", allowed, help);
}

}  // namespace kinegraph
