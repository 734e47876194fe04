#include "core/io/text/toml_file.h"

#include <algorithm>
#include <cstddef>
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

// toml++ destroys and we walk tables recursively, and a key of a hundred
// thousand parts ("a.a.a...") makes as many tables. So the depth is bounded
// before parsing: parts of a key, and brackets within brackets.
class DepthGuard {
 public:
  DepthGuard(const std::string& text, const std::string& file)
      : text_(text), file_(file) {}

  void Check() {
    while (at_ < text_.size()) Step();
  }

 private:
  static constexpr int kMaxParts = 16;
  static constexpr int kMaxBrackets = 32;

  void Step() {
    const char c = text_[at_];
    if (c == '#') {
      SkipTo("\n", 0);
    } else if (c == '"' || c == '\'') {
      SkipString(c);
    } else {
      Count(c);
      ++at_;
    }
  }

  void Count(char c) {
    if (c == '\n') ++line_;
    if (c == '.') {
      if (++parts_ > kMaxParts) Fail();
    } else if (c == '\n' || c == ',' || c == '=') {
      parts_ = 0;
    } else if (c == '[' || c == '{') {
      parts_ = 0;
      if (++brackets_ > kMaxBrackets) Fail();
    } else if (c == ']' || c == '}') {
      parts_ = 0;
      --brackets_;
    }
  }

  // Past the end of a string, or of the text; an open string is the parser's
  // to report.
  void SkipString(char quote) {
    const std::string triple(3, quote);
    if (text_.compare(at_, 3, triple) == 0) {
      SkipTo(triple, 3);
      at_ = std::min(at_ + 3, text_.size());
      return;
    }
    for (++at_; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '\n') return;
      if (c == '\\' && quote == '"') {
        ++at_;
      } else if (c == quote) {
        ++at_;
        return;
      }
    }
  }

  void SkipTo(const std::string& end, size_t offset) {
    const size_t found = std::min(text_.find(end, at_ + offset), text_.size());
    line_ +=
        std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                   text_.begin() + static_cast<std::ptrdiff_t>(found), '\n');
    at_ = found;
  }

  [[noreturn]] void Fail() const {
    throw InputError(file_ + ":" + std::to_string(line_), "",
                     "is nested too deeply for TOML that means something");
  }

  const std::string& text_;
  const std::string& file_;
  size_t at_ = 0;
  std::ptrdiff_t line_ = 1;
  int parts_ = 0;
  int brackets_ = 0;
};

}  // namespace

toml::table ParseToml(const std::string& text, const std::string& file) {
  DepthGuard(text, file).Check();
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
