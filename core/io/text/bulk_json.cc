#include "core/io/text/bulk_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/constants.h"
#include "core/data/checks.h"
#include "core/data/limits.h"
#include "core/io/files/input_files.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/file_head.h"
#include "core/io/text/json.h"
#include "core/io/text/names.h"
#include "core/system/file.h"

namespace kinegraph {
namespace {

constexpr size_t kPadding = simdjson::SIMDJSON_PADDING;
// A frame of a hundred people with a hundred joints and covariances each takes
// some 2 MiB.
constexpr size_t kMaxLineBytes = size_t{64} << 20;
// simdjson's own limit is 4 GiB.
constexpr size_t kMaxFileBytes = size_t{2} << 30;
constexpr int kMaxPeekDepth = 256;  // levels of brackets that ScanKeys accepts
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

// "an object", "an array", "null", ... for messages.
const char* TypeName(JsonValue value) {
  switch (value.type()) {
    case simdjson::dom::element_type::ARRAY:
      return "an array";
    case simdjson::dom::element_type::OBJECT:
      return "an object";
    case simdjson::dom::element_type::STRING:
      return "a text";
    case simdjson::dom::element_type::BOOL:
      return "a boolean";
    case simdjson::dom::element_type::NULL_VALUE:
      return "null";
    default:
      return "a number";
  }
}

[[noreturn]] void FailType(JsonValue value, std::string_view key,
                           const std::string& expected) {
  throw InputError(std::string(key) + ": found " + TypeName(value) +
                   ", expected " + expected);
}

// Error messages for users.
std::string Explain(simdjson::error_code error) {
  switch (error) {
    case simdjson::EMPTY:
      return "is empty, expected JSON";
    case simdjson::NUMBER_ERROR:
      return "is not valid JSON: a number is malformed or out of range";
    case simdjson::DEPTH_ERROR:
      return "is not valid JSON here: it is nested too deeply";
    case simdjson::UTF8_ERROR:
      return "is not valid JSON: it is not UTF-8";
    case simdjson::UNCLOSED_STRING:
      return "is not valid JSON: a text is not closed (truncated?)";
    case simdjson::CAPACITY:
    case simdjson::MEMALLOC:
      return "is too large for this machine's memory";
    default:
      return "is not valid JSON (truncated, or text after its end?)";
  }
}

// Index of the quote that closes the text opened at `open`; text.size() if
// there is none.
size_t EndOfText(std::string_view text, size_t open) {
  size_t i = open + 1;
  while (i < text.size() && text[i] != '"') i += text[i] == '\\' ? 2 : 1;
  return std::min(i, text.size());
}

// `text` with NaN and infinities (NotANumberAt) replaced by null; empty if it
// contains none.
std::string WithNulls(std::string_view text) {
  std::string mended;
  size_t done = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') {
      i = EndOfText(text, i);
      continue;
    }
    const size_t length = NotANumberAt(text.substr(i)).size();
    if (length == 0) continue;
    mended.append(text, done, i - done).append("null");
    done = i + length;
    i = done - 1;
  }
  if (done > 0) mended.append(text, done, std::string_view::npos);
  return mended;
}

// `text` must be followed by simdjson's padding. The value refers to memory of
// the parser.
simdjson::error_code ParseBulk(std::string_view text,
                               simdjson::dom::parser* parser,
                               JsonValue* value) {
  const simdjson::error_code error =
      parser->parse(text.data(), text.size(), false).get(*value);
  if (!error) return error;
  const std::string mended = WithNulls(text);
  if (mended.empty()) return error;
  return parser->parse(mended).get(*value);
}

// The outermost keys of (the beginning of) an object.
std::vector<std::string> ScanKeys(std::string_view text,
                                  const std::string& path) {
  std::vector<std::string> keys;
  int depth = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '{' || c == '[') {
      if (++depth > kMaxPeekDepth) {
        throw InputError(path, "", Explain(simdjson::DEPTH_ERROR));
      }
    } else if (c == '}' || c == ']') {
      if (--depth == 0) break;
    } else if (c == '"') {
      const size_t end = EndOfText(text, i);
      const size_t next = text.find_first_not_of(" \t\r\n", end + 1);
      const bool is_key = next != std::string_view::npos && text[next] == ':';
      if (depth == 1 && is_key)
        keys.emplace_back(text.substr(i + 1, end - i - 1));
      i = end;
    }
  }
  return keys;
}

}  // namespace

JsonArray AsArray(JsonValue value, std::string_view key) {
  JsonArray array;
  if (value.get_array().get(array)) FailType(value, key, "an array");
  return array;
}

JsonObject AsObject(JsonValue value, std::string_view key) {
  JsonObject object;
  if (value.get_object().get(object)) FailType(value, key, "an object");
  return object;
}

double AsNumber(JsonValue value, std::string_view key) {
  double number = 0.0;
  if (value.get_double().get(number)) FailType(value, key, "a number");
  return number;
}

int64_t AsInteger(JsonValue value, std::string_view key, int64_t low,
                  int64_t high) {
  int64_t integer = 0;
  if (value.get_int64().get(integer)) FailType(value, key, "an integer");
  if (integer < low || integer > high) {
    throw InputError(std::string(key) + ": found " + std::to_string(integer) +
                     ", expected " + std::to_string(low) + " .. " +
                     std::to_string(high));
  }
  return integer;
}

std::string_view AsText(JsonValue value, std::string_view key) {
  std::string_view text;
  if (value.get_string().get(text)) FailType(value, key, "a text");
  return text;
}

JsonValue Required(const JsonObject& object, std::string_view key) {
  JsonValue value;
  if (object.at_key(key).get(value)) FailMissing(key);
  return value;
}

void CheckCount(std::string_view key, size_t found, size_t expected,
                const char* what) {
  if (found == expected) return;
  throw InputError(std::string(key) + ": found " + std::to_string(found) +
                   what + ", expected " + std::to_string(expected));
}

void FailMissing(std::string_view key) {
  throw InputError(std::string(key) + ": is missing");
}

void FailTwice(std::string_view key) {
  throw InputError(std::string(key) + ": appears twice");
}

void AsNumbers(JsonValue value, std::string_view key, size_t count,
               double* numbers) {
  AsNumbers(AsArray(value, key), key, count, numbers);
}

void AsNumbers(const JsonArray& array, std::string_view key, size_t count,
               double* numbers) {
  size_t found = 0;
  for (const JsonValue element : array) {
    const double number = element.is_null() ? kNan : AsNumber(element, key);
    if (found < count) numbers[found] = number;
    ++found;
  }
  CheckCount(key, found, count, " numbers");
}

int64_t AsFrame(JsonValue value, std::string_view key) {
  return AsInteger(value, key, 0, kMaxFrame);
}

int64_t AsId(JsonValue value, std::string_view key) {
  return AsInteger(value, key, 0, kMaxId);
}

TimeNs AsTime(JsonValue value, std::string_view key) {
  return CheckedTime(AsNumber(value, key), key);
}

double AsFrameRate(JsonValue value, std::string_view key) {
  if (value.is_null()) return 0.0;
  const double rate_hz = AsNumber(value, key);
  CheckFrameRate(rate_hz > 0.0 ? rate_hz : -1.0, key);
  return rate_hz;
}

bool AreOtherRates(double a_hz, double b_hz) {
  constexpr double kAlike = 0.01;  // rates and times may be inaccurate
  return std::abs(a_hz - b_hz) > kAlike * b_hz;
}

double ChooseFrameRate(double given_hz, double stated_hz, bool refuse_other) {
  if (!(given_hz > 0.0)) return stated_hz;
  if (refuse_other && stated_hz > 0.0 && AreOtherRates(given_hz, stated_hz)) {
    throw InputError(fmt::format(
        "--frame_rate={:g} is for input that does not specify its rate, but "
        "the input specifies {:.6g} Hz",
        given_hz, stated_hz));
  }
  return given_hz;
}

TimeNs TimeOfFrame(int64_t frame, double frame_rate_hz) {
  if (frame_rate_hz == 0.0) return 0;
  if (frame >= kMostFrames) {
    throw InputError("frame " + std::to_string(frame) +
                     ": is too large for a frame number and looks like a time "
                     "since 1970" +
                     kNumberByTime);
  }
  return CheckedTime(static_cast<double>(frame) / frame_rate_hz, "time");
}

JsonValue JsonFileParser::Parse(const std::string& path) {
  std::string text = ReadBytes(path, kMaxFileBytes);
  text.reserve(text.size() + kPadding);
  std::string_view content = text;
  // Some editors write a byte order mark.
  if (content.substr(0, 3) == kByteOrderMark) content.remove_prefix(3);
  JsonValue value;
  const simdjson::error_code error = ParseBulk(content, &parser_, &value);
  if (error) throw InputError(path, "", Explain(error));
  return value;
}

OwnLines::OwnLines(const std::string& path)
    : path_(path), file_(std::fopen(path.c_str(), "rbe")) {
  if (file_ == nullptr) FailToRead(path);
  InputFiles::Note(DescriptorOf(file_.get()), path);
}

OwnLines::OwnLines(const std::string& name, int pipe, int silence_ms)
    : path_(name), file_(StreamOf(pipe, "rb")), silence_ms_(silence_ms) {
  if (file_ == nullptr) FailToRead(name);
}

bool OwnLines::Fill() {
  if (begin_ > 0) {  // moves unread data to the front
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    next_ -= begin_;
    begin_ = 0;
  }
  if (end_ + kPadding == buffer_.size()) {
    if (end_ > kMaxLineBytes) {
      throw InputError(path_, Place(), "is longer than 64 MiB");
    }
    buffer_.resize(2 * buffer_.size());
  }
  // A single read returns the available bytes: a line of a live stream must not
  // wait until later lines fill the buffer.
  const int descriptor = DescriptorOf(file_.get());
  if (silence_ms_ < 0) {
    if (!InputStop::WaitForInput(descriptor)) return false;
  } else if (!HasInput(descriptor, silence_ms_)) {
    throw InputError(path_, "",
                     "its adapter has printed nothing for " +
                         std::to_string(silence_ms_ / 1000) + " s");
  }
  const int64_t got = ReadSome(descriptor, buffer_.data() + end_,
                               buffer_.size() - kPadding - end_);
  if (got < 0) FailToRead(path_);
  end_ += static_cast<size_t>(got);
  // Standard input may be a growing file, which is treated as a stream.
  if (got == 0 && silence_ms_ < 0 && path_ != "/dev/stdin") {
    InputFiles::Note(descriptor, path_);
  }
  return got > 0;
}

bool OwnLines::NextLine() {
  begin_ = next_;
  ++line_number_;
  size_t searched = begin_;
  while (true) {
    const char* data = buffer_.data();
    const void* newline = std::memchr(data + searched, '\n', end_ - searched);
    if (newline != nullptr) {
      next_ = static_cast<size_t>(static_cast<const char*>(newline) - data) + 1;
      length_ = next_ - 1 - begin_;
      return true;
    }
    const size_t searched_of_line = end_ - begin_;
    next_ = begin_;
    if (!Fill()) break;
    searched = begin_ + searched_of_line;
  }
  if (silence_ms_ < 0 && InputStop::HasHappened()) return false;  // incomplete
  length_ = end_ - begin_;  // the last line may lack its newline
  next_ = end_;
  return length_ > 0;
}

bool OwnLines::Next(JsonValue* value) {
  while (NextLine()) {
    if (line_number_ == 1 && line().substr(0, 3) == kByteOrderMark) {
      begin_ += kByteOrderMark.size();
      length_ -= kByteOrderMark.size();
    }
    if (line().find_first_not_of(" \t\r") == std::string_view::npos) continue;
    // The bytes after the line in the buffer serve as simdjson's padding.
    const simdjson::error_code error = ParseBulk(line(), &parser_, value);
    if (error) throw InputError(path_, Place(), Explain(error));
    return true;
  }
  return false;
}

void OwnLines::CheckFrame(int64_t frame) {
  if (frame <= last_frame_) {
    throw InputError("frame: found " + std::to_string(frame) + " after " +
                     std::to_string(last_frame_) +
                     ", expected frames to ascend");
  }
  last_frame_ = frame;
}

int64_t OwnLines::CountFrames() const {
  if (IsPipe(path_)) return -1;
  int64_t count = 0;
  char last = '\n';
  ForEachBlock(path_, [&](std::string_view bytes) {
    count += std::count(bytes.begin(), bytes.end(), '\n');
    last = bytes.back();
  });
  if (last != '\n') ++count;  // the last may lack its newline
  return count - 1;           // without the header
}

bool FileHead::HasKey(std::string_view key) const {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

std::vector<std::string> FileHead::FirstRow() const {
  return FirstCsvRow(beginning);
}

FileHead LookAtFile(const std::string& path) {
  FileHead head;
  head.beginning = FirstBytes(path, size_t{64} << 10);
  MakePlainText(path, &head.beginning);
  const std::string_view text = head.beginning;
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return head;
  head.kind = text[first];
  if (head.kind == '{' || head.kind == '[') {
    head.keys = ScanKeys(text.substr(first), path);
    if (head.kind == '[') head.keys.clear();
  }
  return head;
}

std::string RawObject(std::string_view line, std::string_view key) {
  const simdjson::padded_string padded(line);
  simdjson::ondemand::parser parser;
  simdjson::ondemand::document document;
  if (parser.iterate(padded).get(document)) return "";
  simdjson::ondemand::object object;
  if (document[key].get_object().get(object)) return "";
  std::string_view raw;
  if (object.raw_json().get(raw)) return "";
  return std::string(raw);
}

std::string CompactObject(const std::string& text) {
  simdjson::dom::parser parser;
  JsonValue value;
  if (parser.parse(text).get(value) || !value.is_object()) return "";
  std::string compact(text.size() + kPadding, '\0');
  size_t length = 0;
  if (simdjson::minify(text.data(), text.size(), compact.data(), length)) {
    return "";
  }
  compact.resize(length);
  return compact;
}

}  // namespace kinegraph
