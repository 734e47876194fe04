#include "core/io/text/json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// Builds the value while the parser, which does not recurse, reads the text, so
// that a text beyond the limits is rejected before memory is allocated. (With
// the library's own callback each object in a list costs time proportional to
// the list.)
class Builder final : public nlohmann::json_sax<Json> {
 public:
  Builder(const std::string& text, const std::string& file)
      : text_(text), file_(file) {}

  Json Take() { return std::move(root_); }

  bool null() override { return Put(nullptr); }
  bool boolean(bool value) override { return Put(value); }
  bool number_integer(int64_t value) override { return Put(value); }
  bool number_unsigned(uint64_t value) override { return Put(value); }
  bool number_float(double value, const std::string&) override {
    return Put(value);
  }
  bool string(std::string& value) override { return Put(std::move(value)); }
  bool binary(Json::binary_t&) override { return false; }
  bool start_object(size_t) override {
    keys_.emplace_back();
    return Open(Json::object());
  }
  bool end_object() override {
    keys_.pop_back();
    return Close();
  }
  bool start_array(size_t) override { return Open(Json::array()); }
  bool end_array() override { return Close(); }
  bool key(std::string& key) override;
  [[noreturn]] bool parse_error(size_t position, const std::string& token,
                                const Json::exception& error) override;

 private:
  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(file_, "", message);
  }
  bool Put(Json value) {
    Add(std::move(value));
    return true;
  }
  Json* Add(Json value);
  bool Open(Json value) {
    if (open_.size() >= static_cast<size_t>(kMaxJsonDepth)) {
      Fail("is nested deeper than " + std::to_string(kMaxJsonDepth) +
           " levels");
    }
    open_.push_back(Add(std::move(value)));
    return true;
  }
  bool Close() {
    open_.pop_back();
    return true;
  }

  const std::string& text_;
  const std::string& file_;
  Json root_;
  size_t count_ = 0;
  std::vector<Json*> open_;
  std::vector<std::unordered_set<std::string>> keys_;  // of open objects
};

Json* Builder::Add(Json value) {
  if (++count_ > kMaxJsonValues) {
    Fail("contains more than " + std::to_string(kMaxJsonValues) + " values");
  }
  if (open_.empty()) {
    root_ = std::move(value);
    return &root_;
  }
  Json& parent = *open_.back();
  if (parent.is_array()) {
    parent.push_back(std::move(value));
    return &parent.back();
  }
  Json& member = parent.get_ref<Json::object_t&>().back().second;
  member = std::move(value);
  return &member;
}

bool Builder::key(std::string& key) {
  std::unordered_set<std::string>& keys = keys_.back();
  if (!keys.insert(key).second) {
    throw InputError(file_, "key '" + Printable(key) + "'",
                     "appears twice in one object");
  }
  if (keys.size() > kMaxJsonKeys) {
    Fail("has an object of more than " + std::to_string(kMaxJsonKeys) +
         " keys");
  }
  AppendMember(key, nullptr, open_.back());
  return true;
}

// The library's messages start with "[json.exception.NAME.NUMBER] ".
std::string WithoutPrefix(const std::string& message) {
  const size_t end = message.find("] ");
  return end == std::string::npos ? message : message.substr(end + 2);
}

bool Builder::parse_error(size_t position, const std::string&,
                          const Json::exception& error) {
  const size_t at = std::max<size_t>(position, 1) - 1;
  const std::string_view name =
      NotANumberAt(std::string_view(text_).substr(std::min(at, text_.size())));
  if (name.empty()) Fail("is not JSON: " + WithoutPrefix(error.what()));
  const auto end = text_.begin() + static_cast<std::ptrdiff_t>(at);
  const auto line = std::count(text_.begin(), end, '\n') + 1;
  throw InputError(
      file_ + ":" + std::to_string(line), "",
      "is not JSON: found " + std::string(name) + ", expected a number");
}

// "an object", "an array of 8", "the text 'x'", for messages.
std::string DescribeJson(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  if (value.is_string()) {
    return "the text '" + Printable(value.get_ref<const std::string&>()) + "'";
  }
  return Printable(DumpJson(value));
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
  Builder builder(text, file);
  Json::sax_parse(text, &builder);
  return builder.Take();
}

std::string_view NotANumberAt(std::string_view text) {
  for (const std::string_view name : {"NaN", "Infinity", "-Infinity"}) {
    if (text.substr(0, name.size()) == name) return text.substr(0, name.size());
  }
  return {};
}

std::string DumpJson(const Json& value, int indent) {
  constexpr char kDelete = '\x7f';
  std::string text =
      value.dump(indent, ' ', false, Json::error_handler_t::replace);
  if (text.find(kDelete) == std::string::npos) return text;
  std::string escaped;
  for (const char c : text) {
    if (c == kDelete) {
      escaped += "\\u007f";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string JsonText(const std::string& text) { return DumpJson(Json(text)); }

void AppendMember(const std::string& key, Json value, Json* object) {
  object->get_ref<Json::object_t&>().emplace_back(key, std::move(value));
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
