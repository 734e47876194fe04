#include "core/io/text/toml_file.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/text_file.h"

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
  for (const auto& [position, key] : order) {
    AppendMember(std::string(key->str()), ToJson(*table.get(*key)), &object);
  }
  return object;
}

// Limits depth and number of tables and values before parsing, because toml++
// destroys tables recursively and ToJson recurses over them, and a key with a
// hundred thousand parts ("a.a.a...") creates as many tables. Each dot, even in
// a number, and each opening bracket counts as a level below the outermost
// table. Syntax errors are left to the parser, so strings are followed only as
// long as they are valid (toml_test.cc compares this guard with the parser).
class TomlGuard {
 public:
  TomlGuard(const std::string& text, const std::string& file)
      : text_(text), file_(file) {}

  void Check() {
    while (at_ < text_.size()) Step();
  }

 private:
  static constexpr int kMaxDepth = 32;

  void Step() {
    const char c = text_[at_];
    if (c == '#') {
      at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (c == '"' || c == '\'') {
      SkipString(c);
    } else {
      Count(c);
      ++at_;
    }
  }

  void Count(char c) {
    const bool opens = c == '[' || c == '{';
    if (c == '\n') ++line_;
    if (opens) open_.push_back(depth_);
    if (opens || c == '.') {
      if (++depth_ > kMaxDepth) {
        Fail("is nested deeper than " + std::to_string(kMaxDepth) + " levels");
      }
    } else if (c == ',' || c == '\n') {
      if (open_.empty()) depth_ = 0;
      if (c == ',' && !open_.empty()) depth_ = open_.back() + 1;
    } else if ((c == ']' || c == '}') && !open_.empty()) {
      depth_ = open_.back();
      open_.pop_back();
    }
    if (!opens && c != '.' && c != ',' && c != '\n') return;
    if (++values_ > kMaxJsonValues) {
      Fail("contains more than " + std::to_string(kMaxJsonValues) + " values");
    }
  }

  // Skips to the end of a string or of the text; the parser reports an
  // unterminated string. Three quotes open a multi-line string. Up to five
  // quotes close it, of which all but the last three are part of the string.
  void SkipString(char quote) {
    const bool over_lines = QuotesAt(quote, 3) == 3;
    at_ += over_lines ? 3 : 1;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '\n') {
        if (!over_lines) return;
        ++line_;
      }
      if (c == '\\' && quote == '"') {  // skips the escape, but no newline
        at_ += at_ + 1 < text_.size() && text_[at_ + 1] == '\n' ? 1 : 2;
      } else if (c != quote) {
        ++at_;
      } else {
        const size_t quotes = over_lines ? QuotesAt(quote, 5) : 1;
        at_ += quotes;
        if (!over_lines || quotes >= 3) return;
      }
    }
  }

  // Number of quotes at this position, at most `most`.
  size_t QuotesAt(char quote, size_t most) const {
    size_t count = 0;
    while (count < most && at_ + count < text_.size() &&
           text_[at_ + count] == quote) {
      ++count;
    }
    return count;
  }

  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(file_ + ":" + std::to_string(line_), "", message);
  }

  const std::string& text_;
  const std::string& file_;
  size_t at_ = 0;
  int line_ = 1;
  int depth_ = 0;
  size_t values_ = 0;
  std::vector<int> open_;  // depth before each open bracket
};

}  // namespace

toml::table ParseToml(const std::string& text, const std::string& file) {
  TomlGuard(text, file).Check();
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
  std::ostringstream other;  // dates and times: as toml++ prints them
  node.visit([&other](const auto& value) { other << value; });
  return Json(other.str());
}

Json ReadToml(const std::string& path) {
  return ToJson(ParseToml(ReadTextFile(path, kMaxSmallFileBytes), path));
}

}  // namespace kinegraph
