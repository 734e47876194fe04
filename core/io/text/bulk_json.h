// Fast reading of large JSON files by simdjson: reuses the parser and, for
// lines, the buffer, and checks types on access with messages "found ...,
// expected ...".
// For core/io only.
//
// Uses simdjson's DOM: On Demand, used only by RawObject, does not detect
// invalid text after the values that are read. Both accept duplicate keys,
// which readers of kinegraph's own formats detect (ReadKeys). NaN and Infinity,
// which are not valid JSON but are written by Python, are read as null.
#ifndef KINEGRAPH_CORE_IO_TEXT_BULK_JSON_H_
#define KINEGRAPH_CORE_IO_TEXT_BULK_JSON_H_

#include <simdjson.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/time.h"
#include "core/io/files/text_file.h"

namespace kinegraph {

using JsonValue = simdjson::dom::element;
using JsonArray = simdjson::dom::array;
using JsonObject = simdjson::dom::object;

// Access functions. Each throws InputError "KEY: found ..., expected ..." or
// "KEY: is missing", which does not name the file; callers add file and line
// (Located in text_file.h).
JsonArray AsArray(JsonValue value, std::string_view key);
JsonObject AsObject(JsonValue value, std::string_view key);
double AsNumber(JsonValue value, std::string_view key);
int64_t AsInteger(JsonValue value, std::string_view key, int64_t low,
                  int64_t high);
std::string_view AsText(JsonValue value, std::string_view key);
JsonValue Required(const JsonObject& object, std::string_view key);
// The value of an optional key; false if it is missing or not a T.
template <typename T>
bool Get(const JsonObject& object, std::string_view key, T* value) {
  return object.at_key(key).get(*value) == simdjson::SUCCESS;
}
// Throws InputError such as "KEY: found 3 joints, expected 17" if the counts
// differ; `what` is " joints".
void CheckCount(std::string_view key, size_t found, size_t expected,
                const char* what);
[[noreturn]] void FailMissing(std::string_view key);
[[noreturn]] void FailTwice(std::string_view key);
// Writes exactly `count` numbers to `numbers`; null becomes NaN.
void AsNumbers(JsonValue value, std::string_view key, size_t count,
               double* numbers);
void AsNumbers(const JsonArray& array, std::string_view key, size_t count,
               double* numbers);
// Replaces the key in messages about the outermost value of a text.
inline constexpr std::string_view kOutermost = "the outermost value";

// A frame number, bounded so that arithmetic on it cannot overflow, or an
// identity, which may be any non-negative number, as there is no arithmetic on
// identities.
int64_t AsFrame(JsonValue value, std::string_view key);
int64_t AsId(JsonValue value, std::string_view key);
// A number of seconds that fits TimeNs.
TimeNs AsTime(JsonValue value, std::string_view key);
// A frame rate [Hz]; 0 for null, which means unknown.
double AsFrameRate(JsonValue value, std::string_view key);
// `given_hz`, otherwise the file's `stated_hz`; 0: unknown. Throws InputError,
// which does not name the file, if `refuse_other` and both are known and differ
// (AreOtherRates).
double ChooseFrameRate(double given_hz, double stated_hz, bool refuse_other);
// Whether two rates differ by more than 1 % of `b_hz`.
bool AreOtherRates(double a_hz, double b_hz);
// frame / rate; 0 when the rate is 0. With a rate, throws InputError, which
// does not name the file, for a time beyond kMaxTime_s and for a frame of
// kMostFrames (names.h) or above, since it looks like a time.
TimeNs TimeOfFrame(int64_t frame, double frame_rate_hz);

// A key of an object in kinegraph's own formats: its name, whether it is
// required, and the member function of Reader that stores its value in a
// Target. A reader has one static table of keys per kind of object; of several
// missing keys the first of the table is reported.
enum class Presence { kRequired, kOptional };
template <typename Reader, typename Target>
struct JsonKey {
  std::string_view name;
  Presence presence;
  void (Reader::*read)(JsonValue value, std::string_view name, Target* target);
};

// Calls the member function of each key, in the order of the object; keys that
// are not in the table are ignored. Throws InputError for a duplicate key or a
// missing required key.
template <typename Reader, typename Target, size_t N>
void ReadKeys(const JsonObject& object,
              const JsonKey<Reader, Target> (&keys)[N], Reader* reader,
              Target* target) {
  static_assert(N <= 32);
  uint32_t seen = 0;
  for (const auto field : object) {
    for (size_t k = 0; k < N; ++k) {
      const JsonKey<Reader, Target>& key = keys[k];
      if (key.name != field.key) continue;
      if ((seen >> k & 1U) != 0) FailTwice(field.key);
      seen |= uint32_t{1} << k;
      (reader->*key.read)(field.value, key.name, target);
      break;
    }
  }
  for (size_t k = 0; k < N; ++k) {
    if (keys[k].presence == Presence::kRequired && (seen >> k & 1U) == 0) {
      FailMissing(keys[k].name);
    }
  }
}

// Parses whole files.
class JsonFileParser {
 public:
  // The value is valid until the next call. Throws InputError naming the file.
  JsonValue Parse(const std::string& path);

 private:
  simdjson::dom::parser parser_;
};

// Reads the lines of kinegraph's own formats of detections and tracks: a
// header, then one line per frame. Blank lines are skipped.
class OwnLines {
 public:
  // Throws InputError when the file cannot be read.
  explicit OwnLines(const std::string& path);
  // Reads a pipe and closes it on destruction; messages call it `name`. Reading
  // throws InputError if nothing arrives for `silence_ms`.
  OwnLines(const std::string& name, int pipe, int silence_ms);

  // Calls `read` with the object in the next line; file and line are added to
  // its errors. Throws InputError if there is no line.
  template <typename Read>
  void ReadHeader(const Read& read) {
    if (!ReadLine("the header", read)) {
      throw InputError(path_, "", "is empty, expected a header line");
    }
  }

  // The same for the next frame; false at the end.
  template <typename Read>
  bool ReadFrame(const Read& read) {
    return ReadLine("the frame", read);
  }

  // Throws InputError unless `frame` is above that of the previous call.
  void CheckFrame(int64_t frame);

  // Text of the current line.
  std::string_view line() const { return {buffer_.data() + begin_, length_}; }
  // Number of lines in the whole file, including blank ones, without the
  // header; reads the file again. -1 for a pipe.
  int64_t CountFrames() const;

 private:
  std::string Place() const { return "line " + std::to_string(line_number_); }
  // The next line, valid until the next call; false at the end.
  bool Next(JsonValue* value);
  bool NextLine();
  bool Fill();

  template <typename Read>
  bool ReadLine(std::string_view what, const Read& read) {
    JsonValue value;
    if (!Next(&value)) return false;
    Located(
        path_, [&] { return Place(); }, [&] { read(AsObject(value, what)); });
    return true;
  }

  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
  int silence_ms_ = -1;        // -1: unlimited
  std::vector<char> buffer_ =  // simdjson's padding included
      std::vector<char>((size_t{1} << 16) + simdjson::SIMDJSON_PADDING);
  size_t begin_ = 0;  // start of the current line in buffer_
  size_t length_ = 0;
  size_t next_ = 0;  // start and end of the text after the current line
  size_t end_ = 0;
  int64_t line_number_ = 0;
  int64_t last_frame_ = -1;
  simdjson::dom::parser parser_;
};

// The raw text of the value of `key` in a line with a valid object; empty if it
// is missing or not an object.
std::string RawObject(std::string_view line, std::string_view key);

// The text without white space if it is one valid JSON object, otherwise empty.
std::string CompactObject(const std::string& text);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_BULK_JSON_H_
