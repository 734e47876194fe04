#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

// Five thousand cameras. The parser takes half a kilobyte a value, and aliases
// let a short text stand for a huge one.
constexpr int kMaxValues = 200000;

class YamlConverter {
 public:
  explicit YamlConverter(std::string file) : file_(std::move(file)) {}

  Json Convert(const YAML::Node& node, int depth = 0) {
    if (depth >= kMaxJsonDepth) Fail(node, "is nested too deeply");
    if (++count_ > kMaxValues) Fail(node, "has too many values");
    if (node.IsMap()) return ConvertMap(node, depth);
    if (node.IsSequence()) {
      Json values = Json::array();
      for (const YAML::Node& value : node) {
        values.push_back(Convert(value, depth + 1));
      }
      return values;
    }
    return node.IsScalar() ? ConvertScalar(node) : Json(nullptr);
  }

 private:
  [[noreturn]] void Fail(const YAML::Node& node,
                         const std::string& message) const {
    throw InputError(file_ + ":" + std::to_string(node.Mark().line + 1), "",
                     message);
  }

  Json ConvertMap(const YAML::Node& node, int depth) {
    if (node.size() > kMaxJsonKeys) Fail(node, "has too many keys");
    Json object = Json::object();
    for (const auto& member : node) {
      if (!member.first.IsScalar()) Fail(member.first, "a key is no text");
      const std::string& key = member.first.Scalar();
      if (object.contains(key)) {
        Fail(member.first, "key '" + Printable(key) + "' appears twice");
      }
      object[key] = Convert(member.second, depth + 1);
    }
    const bool is_matrix = object.contains("rows") && object.contains("cols") &&
                           object.contains("data");
    return is_matrix ? ToRows(node, object) : object;
  }

  Json ToRows(const YAML::Node& node, const Json& matrix) const {
    const JsonField field(matrix, file_,
                          "line " + std::to_string(node.Mark().line + 1));
    const int64_t rows = field.At("rows").Integer();
    const int64_t cols = field.At("cols").Integer();
    const JsonField data = field.At("data");
    const auto count = static_cast<int64_t>(data.value().size());
    if (!data.value().is_array() || rows < 0 || cols < 0 || rows > kMaxValues ||
        cols > kMaxValues || rows * cols != count) {
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

  static Json ConvertScalar(const YAML::Node& node) {
    const std::string& text = node.Scalar();
    const bool quoted = node.Tag() == "!";
    const auto number = ParseNumber<double>(WithoutPlus(text));
    return !quoted && number.has_value() ? Json(*number) : Json(text);
  }

  std::string file_;
  int count_ = 0;
};

// Goes through a text without keeping it, and stops at what would never end:
// yaml-cpp sees document after document in a stray comma, and a value between
// any two commas of a list.
class YamlGuard final : public YAML::EventHandler {
 public:
  explicit YamlGuard(std::string file) : file_(std::move(file)) {}

  int documents() const { return documents_; }

  void OnDocumentStart(const YAML::Mark&) override { ++documents_; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { Count(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { Count(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string&) override {
    Count(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&,
                       YAML::anchor_t, YAML::EmitterStyle::value) override {
    Count(mark);
  }
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    Count(mark);
  }
  void OnMapEnd() override {}

 private:
  void Count(const YAML::Mark& mark) {
    if (++values_ <= 2 * kMaxValues) return;  // keys count too
    throw InputError(file_ + ":" + std::to_string(mark.line + 1), "",
                     "has too many values");
  }

  const std::string file_;
  int documents_ = 0;
  int values_ = 0;
};

// Throws unless the text is one document of a bounded size.
void RefuseEndless(const std::string& text, const std::string& file) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  YamlGuard guard(file);
  while (guard.documents() <= 1 && parser.HandleNextDocument(guard)) {
  }
  if (guard.documents() == 1) return;
  throw InputError(file, "",
                   guard.documents() == 0
                       ? "holds no YAML document, expected one"
                       : "holds more than one YAML document, or a stray comma");
}

// The parser takes a second for each million open brackets before it refuses
// them. Brackets in texts count too; no calibration has that many.
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

// OpenCV writes "%YAML:1.0", which YAML does not know. The line stays, empty,
// so that line numbers are the file's.
std::string WithoutDirective(const std::string& text) {
  if (text.rfind("%YAML", 0) != 0) return text;
  const size_t end = text.find('\n');
  return end == std::string::npos ? std::string() : text.substr(end);
}

}  // namespace

Json ParseYaml(const std::string& text, const std::string& file) {
  RefuseDeepBrackets(text, file);
  const std::string document = WithoutDirective(text);
  YAML::Node root;
  try {
    RefuseEndless(document, file);
    root = YAML::Load(document);
  } catch (const YAML::Exception& error) {
    const std::string line =
        error.mark.is_null() ? "" : ":" + std::to_string(error.mark.line + 1);
    throw InputError(file + line, "", "is not YAML: " + error.msg);
  }
  return YamlConverter(file).Convert(root);
}

}  // namespace kinegraph
