#include "core/io/text/json.h"

#include <cmath>
#include <unordered_set>
#include <utility>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// Watches a parse for what the parser lets pass.
class ParseGuard {
 public:
  explicit ParseGuard(std::string file) : file_(std::move(file)) {}

  void See(int depth, Json::parse_event_t event, const Json& parsed) {
    using Event = Json::parse_event_t;
    if (event == Event::object_start || event == Event::array_start) {
      if (depth >= kMaxJsonDepth) {
        throw InputError(file_, "",
                         "is nested deeper than " +
                             std::to_string(kMaxJsonDepth) + " levels");
      }
      if (event == Event::object_start) keys_.emplace_back();
    } else if (event == Event::object_end) {
      keys_.pop_back();
    } else if (event == Event::key) {
      SeeKey(parsed.get_ref<const std::string&>());
    }
  }

 private:
  void SeeKey(const std::string& key) {
    if (!keys_.back().insert(key).second) {
      throw InputError(file_, "key '" + Printable(key) + "'",
                       "appears twice in one object");
    }
    if (keys_.back().size() > kMaxJsonKeys) {
      throw InputError(file_, "",
                       "has an object of more than " +
                           std::to_string(kMaxJsonKeys) + " keys");
    }
  }

  std::string file_;
  std::vector<std::unordered_set<std::string>> keys_;  // of open objects
};

// The library's messages start with "[json.exception.NAME.NUMBER] ".
std::string WithoutPrefix(const std::string& message) {
  const size_t end = message.find("] ");
  return end == std::string::npos ? message : message.substr(end + 2);
}

std::string Counted(int rows, int cols) {
  if (cols == 1) return std::to_string(rows) + " numbers";
  return std::to_string(rows) + " x " + std::to_string(cols) + " numbers";
}

}  // namespace

Json ParseJson(const std::string& text, const std::string& file) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
    throw InputError(file, "", "is empty, expected JSON");
  }
  ParseGuard guard(file);
  try {
    return Json::parse(
        text, [&guard](int depth, Json::parse_event_t event, Json& parsed) {
          guard.See(depth, event, parsed);
          return true;
        });
  } catch (const Json::exception& error) {
    throw InputError(file, "", "is not JSON: " + WithoutPrefix(error.what()));
  }
}

std::string DescribeJson(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  if (value.is_string()) {
    return "the text '" + Printable(value.get_ref<const std::string&>()) + "'";
  }
  return Printable(value.dump());
}

JsonField::JsonField(const Json& value, std::string file, std::string where)
    : value_(&value), file_(std::move(file)), where_(std::move(where)) {}

JsonField JsonField::Named(std::string where) const {
  return {*value_, file_, std::move(where)};
}

void JsonField::Fail(const std::string& message) const {
  throw InputError(file_, where_, message);
}

void JsonField::FailExpected(const std::string& what) const {
  Fail("found " + DescribeJson(*value_) + ", expected " + what);
}

std::optional<JsonField> JsonField::Find(const std::string& key) const {
  if (!value_->is_object()) FailExpected("an object with '" + key + "'");
  const auto at = value_->find(key);
  if (at == value_->end()) return std::nullopt;
  return JsonField(*at, file_, where_.empty() ? key : where_ + ": " + key);
}

JsonField JsonField::At(const std::string& key) const {
  std::optional<JsonField> field = Find(key);
  if (!field.has_value()) Fail("has no key '" + key + "'");
  return *std::move(field);
}

std::vector<JsonField::Member> JsonField::Members(
    const std::string& kind) const {
  if (!value_->is_object()) FailExpected("an object");
  std::vector<Member> members;
  for (const auto& [key, value] : value_->items()) {
    members.push_back(
        {key, JsonField(value, file_, kind + " '" + Printable(key) + "'")});
  }
  return members;
}

std::vector<JsonField> JsonField::Elements(const std::string& kind) const {
  if (!value_->is_array()) FailExpected("an array");
  std::vector<JsonField> elements;
  for (const Json& value : *value_) {
    elements.emplace_back(value, file_,
                          kind + " " + std::to_string(elements.size()));
  }
  return elements;
}

std::string JsonField::Text() const {
  if (!value_->is_string()) FailExpected("a text");
  return value_->get<std::string>();
}

bool JsonField::Boolean() const {
  if (!value_->is_boolean()) FailExpected("true or false");
  return value_->get<bool>();
}

double JsonField::Number() const {
  if (!value_->is_number()) FailExpected("a number");
  const auto number = value_->get<double>();
  if (!std::isfinite(number)) Fail("a number is not finite");
  return number;
}

int64_t JsonField::Integer() const {
  constexpr double kLargest = 9007199254740992.0;  // 2^53
  const double number = Number();
  if (number != std::floor(number) || std::abs(number) > kLargest) {
    FailExpected("a whole number");
  }
  return static_cast<int64_t>(number);
}

std::vector<int64_t> JsonField::Integers(int count) const {
  std::vector<int64_t> integers;
  for (const double number : Matrix(count, 1)) {
    const Json value = number;
    integers.push_back(JsonField(value, file_, where_).Integer());
  }
  return integers;
}

std::vector<double> JsonField::Matrix(int rows, int cols) const {
  const size_t count = static_cast<size_t>(rows) * static_cast<size_t>(cols);
  const auto fail = [&] { FailExpected(Counted(rows, cols)); };
  if (!value_->is_array() || value_->empty()) fail();
  std::vector<double> numbers;
  const auto append = [&](const Json& value) {
    if (!value.is_number()) {
      JsonField(value, file_, where_).FailExpected("a number");
    }
    numbers.push_back(JsonField(value, file_, where_).Number());
  };
  if (!value_->front().is_array()) {  // flat
    if (value_->size() != count) fail();
    for (const Json& value : *value_) append(value);
    return numbers;
  }
  const bool row_vector = cols == 1 && value_->size() == 1;
  const auto expected_rows = static_cast<size_t>(row_vector ? 1 : rows);
  const auto expected_cols = static_cast<size_t>(row_vector ? rows : cols);
  if (value_->size() != expected_rows) fail();
  for (const Json& row : *value_) {
    if (!row.is_array() || row.size() != expected_cols) fail();
    for (const Json& value : row) append(value);
  }
  return numbers;
}

std::vector<double> JsonField::Numbers() const {
  if (!value_->is_array()) FailExpected("an array of numbers");
  if (value_->empty()) return {};
  const bool row = value_->size() == 1 && value_->front().is_array();
  const size_t count = row ? value_->front().size() : value_->size();
  if (count == 0) return {};
  return Matrix(static_cast<int>(count), 1);
}

}  // namespace kinegraph
