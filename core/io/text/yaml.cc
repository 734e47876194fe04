#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

// Limit of the memory for values, which is kValueBytes per value plus its text.
// Enough for five thousand cameras. With aliases a short text can represent a
// huge one, so each copy is counted.
constexpr size_t kMaxBytes = size_t{16} << 20;
constexpr size_t kValueBytes = 64;

size_t BytesOf(const Json& value) {
  size_t bytes = kValueBytes;
  if (value.is_string()) bytes += value.get_ref<const std::string&>().size();
  if (value.is_array()) {
    for (const Json& element : value) bytes += BytesOf(element);
  }
  if (value.is_object()) {
    for (const auto& [key, member] : value.items()) {
      bytes += key.size() + BytesOf(member);
    }
  }
  return bytes;
}

// Builds the value while the parser reads the text, and stops the parser at the
// limits: a value takes far more memory than the comma that creates it.
class YamlBuilder final : public YAML::EventHandler {
 public:
  explicit YamlBuilder(std::string file) : file_(std::move(file)) {}

  Json Take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Put(mark, nullptr, anchor);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag,
                YAML::anchor_t anchor, const std::string& text) override {
    if (WantsKey()) return TakeKey(mark, text);
    const bool quoted = tag == "!";
    const auto number = ParseNumber<double>(WithoutPlus(text));
    Put(mark, !quoted && number.has_value() ? Json(*number) : Json(text),
        anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto named = anchors_.find(anchor);
    if (named == anchors_.end()) Fail(mark, "a value refers to itself");
    Put(mark, named->second, 0);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&,
                       YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Open(mark, Json::array(), anchor);
  }
  void OnSequenceEnd() override { Close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&,
                  YAML::anchor_t anchor, YAML::EmitterStyle::value) override {
    Open(mark, Json::object(), anchor);
  }
  void OnMapEnd() override { Close(); }

 private:
  struct Container {
    YAML::Mark mark;
    Json value;
    YAML::anchor_t anchor;
    bool has_key = false;
  };

  [[noreturn]] void Fail(const YAML::Mark& mark,
                         const std::string& message) const {
    throw InputError(file_ + ":" + std::to_string(mark.line + 1), "", message);
  }

  bool WantsKey() const {
    return !open_.empty() && open_.back().value.is_object() &&
           !open_.back().has_key;
  }

  void TakeKey(const YAML::Mark& mark, const std::string& key) {
    Container& map = open_.back();
    if (map.value.contains(key)) {
      Fail(mark, "key '" + Printable(key) + "' appears twice");
    }
    if (map.value.size() >= kMaxJsonKeys) Fail(mark, "has too many keys");
    AppendMember(key, nullptr, &map.value);
    map.has_key = true;
  }

  void Pay(const YAML::Mark& mark, size_t bytes) {
    bytes_ += bytes;
    if (bytes_ > kMaxBytes) Fail(mark, "has too many values");
  }

  void Put(const YAML::Mark& mark, Json value, YAML::anchor_t anchor) {
    if (WantsKey()) Fail(mark, "a key is not a text");
    Pay(mark, BytesOf(value));
    Add(mark, std::move(value), anchor);
  }

  // Adds a value that is already counted.
  void Add(const YAML::Mark& mark, Json value, YAML::anchor_t anchor) {
    if (anchor != 0) {
      Pay(mark, BytesOf(value));
      anchors_[anchor] = value;
    }
    if (open_.empty()) {
      root_ = std::move(value);
      return;
    }
    Container& parent = open_.back();
    if (parent.value.is_array()) {
      parent.value.push_back(std::move(value));
    } else {
      parent.value.get_ref<Json::object_t&>().back().second = std::move(value);
      parent.has_key = false;
    }
  }

  void Open(const YAML::Mark& mark, Json value, YAML::anchor_t anchor) {
    if (WantsKey()) Fail(mark, "a key is not a text");
    if (open_.size() >= static_cast<size_t>(kMaxJsonDepth)) {
      Fail(mark, "is nested deeper than " + std::to_string(kMaxJsonDepth) +
                     " levels");
    }
    Pay(mark, kValueBytes);
    open_.push_back({mark, std::move(value), anchor});
  }

  void Close() {
    Container closed = std::move(open_.back());
    open_.pop_back();
    const bool is_matrix =
        closed.value.is_object() && closed.value.contains("rows") &&
        closed.value.contains("cols") && closed.value.contains("data");
    Add(closed.mark,
        is_matrix ? ToRows(closed.mark, closed.value) : std::move(closed.value),
        closed.anchor);
  }

  Json ToRows(const YAML::Mark& mark, const Json& matrix) const {
    const JsonField field(matrix, file_,
                          "line " + std::to_string(mark.line + 1));
    const int64_t rows = field.At("rows").Integer();
    const int64_t cols = field.At("cols").Integer();
    const JsonField data = field.At("data");
    const auto count = static_cast<int64_t>(data.value().size());
    constexpr auto kMost = static_cast<int64_t>(kMaxBytes / kValueBytes);
    if (!data.value().is_array() || rows < 0 || cols < 0 || rows > kMost ||
        cols > kMost || rows * cols != count) {
      data.FailExpected(std::to_string(rows) + " x " + std::to_string(cols) +
                        " numbers");
    }
    Json nested = Json::array();
    for (int64_t r = 0; r < rows; ++r) {
      Json row = Json::array();
      for (int64_t c = 0; c < cols; ++c) {
        row.push_back(data.value()[static_cast<size_t>(r * cols + c)]);
      }
      nested.push_back(std::move(row));
    }
    return nested;
  }

  const std::string file_;
  Json root_;
  std::vector<Container> open_;
  std::map<YAML::anchor_t, Json> anchors_;
  size_t bytes_ = 0;
};

// Limits the depth before parsing: the parser needs a second for each million
// open brackets before it reports the first value. Brackets in texts also
// count, but no calibration has so many.
void RefuseDeepBrackets(const std::string& text, const std::string& file) {
  int depth = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (depth > kMaxJsonDepth) {
      throw InputError(
          file, "",
          "is nested deeper than " + std::to_string(kMaxJsonDepth) + " levels");
    }
  }
}

// OpenCV writes "%YAML:1.0", which is not valid YAML. The line is replaced by
// an empty one, to preserve line numbers.
std::string WithoutDirective(const std::string& text) {
  if (text.rfind("%YAML", 0) != 0) return text;
  const size_t end = text.find('\n');
  return end == std::string::npos ? std::string() : text.substr(end);
}

}  // namespace

Json ParseYaml(const std::string& text, const std::string& file) {
  RefuseDeepBrackets(text, file);
  std::istringstream stream(WithoutDirective(text));
  YamlBuilder builder(file);
  YamlBuilder further(file);
  try {
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder)) {
      throw InputError(file, "", "contains no YAML document, expected one");
    }
    if (parser.HandleNextDocument(further)) {
      throw InputError(
          file, "", "contains more than one YAML document, or a stray comma");
    }
  } catch (const YAML::Exception& error) {
    const std::string line =
        error.mark.is_null() ? "" : ":" + std::to_string(error.mark.line + 1);
    throw InputError(file + line, "", "is not YAML: " + error.msg);
  }
  return builder.Take();
}

}  // namespace kinegraph
