// Bulk JSON through simdjson: one parser and one buffer that are used again,
// and access that says what was found and what was expected. Only sources
// include this header, so that nobody else needs simdjson.
//
// The DOM is used, not On Demand, which accepts garbage after what it reads.
// Neither minds duplicate keys: readers of our own formats go through the keys
// one by one and notice them (ReadKeys). NaN and Infinity, which JSON does not
// know and Python writes all the same, are read as null.
#ifndef KINEGRAPH_CORE_IO_TEXT_BULK_JSON_H_
#define KINEGRAPH_CORE_IO_TEXT_BULK_JSON_H_

#include <simdjson.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
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

// Access. Each throws InputError "KEY: found ..., expected ..." without a file;
// who knows file and line adds them (see Located).
JsonArray AsArray(JsonValue value, std::string_view key);
JsonObject AsObject(JsonValue value, std::string_view key);
double AsNumber(JsonValue value, std::string_view key);
int64_t AsInteger(JsonValue value, std::string_view key, int64_t low,
                  int64_t high);
std::string_view AsText(JsonValue value, std::string_view key);
JsonValue Required(const JsonObject& object, std::string_view key);
// The value of a key that may be missing; false where it is, or no T.
template <typename T>
bool Get(const JsonObject& object, std::string_view key, T* value) {
  return object.at_key(key).get(*value) == simdjson::SUCCESS;
}
// Throws "KEY: found 3 joints, expected 17"; `what` is " joints".
void CheckCount(std::string_view key, size_t found, size_t expected,
                const char* what);
[[noreturn]] void FailMissing(std::string_view key);
[[noreturn]] void FailTwice(std::string_view key);
// Exactly `count` numbers, written to `numbers`; null becomes NaN.
void AsNumbers(JsonValue value, std::string_view key, size_t count,
               double* numbers);
void AsNumbers(const JsonArray& array, std::string_view key, size_t count,
               double* numbers);
// Name of the value that is the whole text, as a key.
inline constexpr std::string_view kOutermost = "the outermost value";
// "an object", "an array", "null", ... for messages.
const char* TypeName(JsonValue value);

// Frame numbers: large enough for any recording, small enough that no
// arithmetic on them overflows. Identities: every reader takes what every
// writer may write, and nobody computes with them.
int64_t AsFrame(JsonValue value, std::string_view key);
int64_t AsId(JsonValue value, std::string_view key);
// A number of seconds that fits TimeNs.
TimeNs AsTime(JsonValue value, std::string_view key);
// A frame rate [Hz]; null means that it is not known and gives 0.
double AsFrameRate(JsonValue value, std::string_view key);
// frame / rate; 0 when the rate is 0.
TimeNs TimeOfFrame(int64_t frame, double frame_rate_hz);

// A key of an object of our own formats: its name, whether it must be there,
// and the member of Reader that takes its value over into a Target. Readers
// hold one table of them an object, static, in the order in which what is
// missing is named.
enum class Presence { kRequired, kOptional };
template <typename Reader, typename Target>
struct JsonKey {
  std::string_view name;
  Presence presence;
  void (Reader::*read)(JsonValue value, std::string_view name, Target* target);
};

// Calls the member of each key in the order of the object; keys that the table
// does not name are passed over. Throws InputError where one comes twice, or
// one that must be there does not.
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

// Runs `read` and puts file and place in front of the message of its
// InputError. `place` is a function, so that nothing is built when all is well.
template <typename Place, typename Read>
auto Located(const std::string& file, const Place& place, const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw InputError(file, place(), error.what());
  }
}

template <typename Read>
auto Located(const std::string& file, const Read& read) {
  return Located(
      file, [] { return ""; }, read);
}

// Whole files.
class JsonFileParser {
 public:
  // Valid until the next call. Throws InputError naming the file.
  JsonValue Parse(const std::string& path);

 private:
  simdjson::dom::parser parser_;
};

// The lines of our own formats, detections and tracks: a header, then a line a
// frame; blank ones are passed over.
class OwnLines {
 public:
  // Throws InputError when the file cannot be read.
  explicit OwnLines(const std::string& path);
  // Of a pipe, which it closes; `name` stands for it in messages. Silence of
  // more than `silence_ms` throws InputError.
  OwnLines(const std::string& name, int pipe, int silence_ms);

  // `read` gets the object that the next line holds; file and line stand in
  // front of what it throws. Throws InputError where there is no line.
  template <typename Read>
  void ReadHeader(const Read& read) {
    if (!ReadLine("the header", read)) {
      throw InputError(path_, "", "is empty, expected a header line");
    }
  }

  // The same for the lines after it; false at the end.
  template <typename Read>
  bool ReadFrame(const Read& read) {
    return ReadLine("the frame", read);
  }

  // Throws InputError unless frames ascend.
  void CheckFrame(int64_t frame);

  // Text of the line that is being read.
  std::string_view line() const { return {buffer_.data() + begin_, length_}; }
  // Of the whole file, read once more; -1 when it is a pipe.
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
  int silence_ms_ = -1;       // none is too long
  std::vector<char> buffer_;  // simdjson's padding included
  size_t begin_ = 0;          // of the current line
  size_t length_ = 0;
  size_t next_ = 0;  // where the unread text begins and ends
  size_t end_ = 0;
  int64_t line_number_ = 0;
  int64_t last_frame_ = -1;
  simdjson::dom::parser parser_;
};

// What a JSON file begins with, to recognise its format by.
struct JsonHead {
  char kind = '\0';  // '{', '[', or the first character of something else
  std::vector<std::string> keys;  // outermost keys in the first 64 KiB

  bool Has(std::string_view key) const;
};
JsonHead PeekJson(const std::string& path);

// The raw text of the value of `key` in a line that holds a valid object; empty
// when there is none or it is no object.
std::string RawObject(std::string_view line, std::string_view key);

// The text without white space when it is one valid JSON object, else empty.
std::string CompactObject(const std::string& text);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_BULK_JSON_H_
