// JSON of small files (calibrations, not detections): strict parsing, and
// access with errors that name file and key.
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

// Limits for small files (docs/limits.md).
// Levels of nesting, also of YAML; bounds recursion.
inline constexpr int kMaxJsonDepth = 64;
// Keys of one object, also of YAML; bounds the time of lookups, which are
// linear.
inline constexpr size_t kMaxJsonKeys = 4096;
// Values of one file, also of TOML; bounds memory.
inline constexpr size_t kMaxJsonValues = 1'000'000;

// Parses one JSON text. Throws InputError naming `file` for an empty text, a
// syntax error (with line and column), NaN or an infinity (with the line), an
// unrepresentable number (1e400), a repeated key or a text beyond the limits
// above.
Json ParseJson(const std::string& text, const std::string& file);

// Parses YAML, one document as OpenCV's FileStorage writes it. A map of rows,
// cols and data (OpenCV's !!opencv-matrix) becomes an array of rows. Unquoted
// numbers and nulls are converted; all other scalars, such as true, become
// texts. Throws InputError naming `file` (and, where it is known, the line) for
// a syntax error, a key that is repeated or not a text, more than kMaxJsonKeys
// keys of one map, nesting deeper than kMaxJsonDepth, more than 16 MiB of
// values with aliases expanded, and unless there is exactly one document.
Json ParseYaml(const std::string& text, const std::string& file);

// The prefix of `text` that is NaN or an infinity in Python's notation, which
// is not valid JSON; empty if there is none.
std::string_view NotANumberAt(std::string_view text);

// The JSON text of a value, on one line or with lines indented by `indent`.
// Bytes that are not UTF-8, which file names and labels may contain, become
// U+FFFD. Texts and lists of texts are also valid TOML, which requires U+007F
// to be escaped.
std::string DumpJson(const Json& value, int indent = -1);

// `text` as a JSON string, with quotes.
std::string JsonText(const std::string& text);

// Adds a member without searching for its key, which the object must not have.
void AppendMember(const std::string& key, Json value, Json* object);

// A value, with its file and its path in the file for messages. Does not own
// the value.
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
  // Throws InputError "file: where: found ..., expected `what`".
  [[noreturn]] void FailExpected(const std::string& what) const;

  // The following functions throw InputError if the value is of another kind.
  //
  // A member of an object. If it is missing, Find returns nullopt and At throws
  // InputError.
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
  // A whole number within +-2^53, which may be written as 1032.0.
  int64_t Integer() const;
  // `count` whole numbers: a flat array, a row or a column.
  std::vector<int64_t> Integers(int count) const;
  // The numbers of a matrix, row-major: a flat array or an array of rows. A
  // single column may be an array of rows or one row. All numbers must be
  // finite.
  std::vector<double> Matrix(int rows, int cols) const;
  // Any number of numbers, as a flat array, a row or a column.
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
