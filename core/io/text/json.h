// JSON of small files (calibrations, not detections): strict parsing, and
// access that names file and key when something is not as expected.
#ifndef KINEGRAPH_CORE_IO_TEXT_JSON_H_
#define KINEGRAPH_CORE_IO_TEXT_JSON_H_

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kinegraph {

// Keeps the order of the file.
using Json = nlohmann::ordered_json;

// Bounds on what a small file may hold, TOML and YAML too (docs/limits.md): the
// first keeps recursion shallow, the second the time that looking keys up one
// by one can take, the third memory.
inline constexpr int kMaxJsonDepth = 64;
inline constexpr size_t kMaxJsonKeys = 4096;
inline constexpr size_t kMaxJsonValues = 1'000'000;

// Parses one JSON text. Throws InputError naming `file` (and line and column)
// for a syntax error, NaN, an unrepresentable number (1e400), a repeated key,
// and what exceeds the bounds above.
Json ParseJson(const std::string& text, const std::string& file);

// The same values of other texts.
//
// YAML as OpenCV's FileStorage writes it, one document. A map of rows, cols and
// data (OpenCV's !!opencv-matrix) becomes an array of rows. Unquoted scalars
// that are numbers become numbers, all others texts. Throws InputError naming
// `file` and line for a syntax error, a repeated key, deep nesting, or more
// than 16 MiB of values, aliases written out.
Json ParseYaml(const std::string& text, const std::string& file);

// NaN or an infinity as Python writes them into JSON, which knows neither: the
// one that `text` begins with; empty where it begins with none.
std::string_view NotANumberAt(std::string_view text);

// The text of a value, on one line or with lines indented by `indent`. Bytes
// that are no UTF-8, as file names and labels may hold, become U+FFFD. Texts
// and lists of them are TOML as well, which wants U+007F escaped.
std::string DumpJson(const Json& value, int indent = -1);

// `text` in quotes.
std::string JsonText(const std::string& text);

// Adds a key that the object is known not to have, without looking for it.
void AppendMember(const std::string& key, Json value, Json* object);

// "an object", "an array of 8", "the text 'x'": what a message says was found.
std::string DescribeJson(const Json& value);

// A value and its place, for messages. Does not own the value.
class JsonField {
 public:
  JsonField(const Json& value, std::string file, std::string where = "");

  const Json& value() const { return *value_; }
  const std::string& file() const { return file_; }
  const std::string& where() const { return where_; }

  // The same value under another name in messages.
  JsonField Named(std::string where) const;

  // Throws InputError "file: where: message".
  [[noreturn]] void Fail(const std::string& message) const;
  // Throws "found ..., expected `what`".
  [[noreturn]] void FailExpected(const std::string& what) const;

  // The member of an object; Find gives nullopt, At fails, when it is missing.
  std::optional<JsonField> Find(const std::string& key) const;
  JsonField At(const std::string& key) const;
  // Members in file order; messages call them "`kind` 'key'".
  struct Member;
  std::vector<Member> Members(const std::string& kind) const;
  // Elements of an array; messages call them "`kind` 0".
  std::vector<JsonField> Elements(const std::string& kind) const;

  std::string Text() const;
  bool Boolean() const;
  double Number() const;  // finite
  // A number without fraction within +-2^53; 1032.0 passes.
  int64_t Integer() const;
  std::vector<int64_t> Integers(int count) const;
  // Row-major, flat or an array of rows; a column or row may be nested either
  // way. All numbers finite.
  std::vector<double> Matrix(int rows, int cols) const;
  // Any count of numbers, flat, as a row or as a column.
  std::vector<double> Numbers() const;

 private:
  const Json* value_;
  std::string file_;
  std::string where_;
};

struct JsonField::Member {
  std::string key;
  JsonField field;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_JSON_H_
