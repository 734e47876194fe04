#include "core/io/binary/npz_reader.h"

#include <cstring>
#include <limits>

#include "core/base/error.h"
#include "core/base/split.h"
#include "core/io/binary/npz_file.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

// A number of the archive's structures, which are little-endian.
template <typename Value>
Value Get(std::string_view bytes, size_t at) {
  Value value{};
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

void AppendUtf8(char32_t point, std::string* text) {
  const auto put = [text](char32_t byte) {
    *text += static_cast<char>(static_cast<unsigned char>(byte));
  };
  if (point < 0x80) return put(point);
  if (point < 0x800) {
    put(0xC0U | point >> 6U);
  } else {
    if (point < 0x10000) {
      put(0xE0U | point >> 12U);
    } else {
      put(0xF0U | point >> 18U);
      put(0x80U | (point >> 12U & 0x3FU));
    }
    put(0x80U | (point >> 6U & 0x3FU));
  }
  put(0x80U | (point & 0x3FU));
}

// What stands between `begin` and `end` in the dictionary of an .npy header.
std::string Between(const std::string& dictionary, const std::string& begin,
                    char end) {
  const size_t at = dictionary.find(begin);
  if (at == std::string::npos) return "";
  const size_t from = at + begin.size();
  const size_t to = dictionary.find(end, from);
  return to == std::string::npos ? "" : dictionary.substr(from, to - from);
}

template <typename From, typename To>
std::vector<To> Cast(std::string_view bytes) {
  std::vector<To> values(bytes.size() / sizeof(From));
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<To>(Get<From>(bytes, i * sizeof(From)));
  }
  return values;
}

// Empty for a type that is none of NumPy's integers.
template <typename To>
bool CastIntegers(const NpyArray& array, std::vector<To>* values) {
  const std::string& type = array.type;
  if (type == "|i1") *values = Cast<int8_t, To>(array.bytes);
  if (type == "|u1") *values = Cast<uint8_t, To>(array.bytes);
  if (type == "<i2") *values = Cast<int16_t, To>(array.bytes);
  if (type == "<i4") *values = Cast<int32_t, To>(array.bytes);
  if (type == "<i8") *values = Cast<int64_t, To>(array.bytes);
  return type == "|i1" || type == "|u1" || type == "<i2" || type == "<i4" ||
         type == "<i8";
}

}  // namespace

size_t NpyArray::Count() const {
  size_t count = 1;
  for (const size_t side : shape) count *= side;
  return count;
}

NpzReader::NpzReader(const std::string& path)
    : path_(path), text_(ReadBytes(path)) {
  if (text_.compare(0, 6, "\x93NUMPY") == 0) {
    arrays_[""] = Parse("", text_);
    return;
  }
  ReadDirectory();
}

void NpzReader::Fail(const std::string& name,
                     const std::string& message) const {
  throw InputError(path_, name, message);
}

// Section 4.3.16 of the archive's description: the end is found from behind, a
// comment may follow it. Then each entry of the central directory (4.3.12),
// whose sizes count; a local header (4.3.7) only tells where its data begin.
void NpzReader::ReadDirectory() {
  constexpr size_t kEndBytes = 22;
  constexpr size_t kEntryBytes = 46;
  constexpr size_t kLocalBytes = 30;
  const std::string_view text = text_;
  const size_t end = text.rfind("PK\x05\x06");
  if (end == std::string_view::npos || text.size() - end < kEndBytes) {
    Fail("", "is no complete .npz archive");
  }
  const auto count = Get<uint16_t>(text, end + 10);
  size_t at = Get<uint32_t>(text, end + 16);
  size_t all_bytes = 0;  // many entries may name the same data
  for (int i = 0; i < count; ++i) {
    if (at > end || end - at < kEntryBytes ||
        text.substr(at, 4) != "PK\x01\x02") {
      Fail("", "has a damaged directory");
    }
    const auto method = Get<uint16_t>(text, at + 10);
    const auto crc = Get<uint32_t>(text, at + 16);
    const size_t size = Get<uint32_t>(text, at + 20);
    const size_t name_size = Get<uint16_t>(text, at + 28);
    const size_t extra_size = Get<uint16_t>(text, at + 30);
    const size_t comment_size = Get<uint16_t>(text, at + 32);
    const size_t local = Get<uint32_t>(text, at + 42);
    if (end - at < kEntryBytes + name_size) Fail("", "has a damaged directory");
    std::string name(text.substr(at + kEntryBytes, name_size));
    const std::string extension = ".npy";
    if (EndsIn(name, extension)) {
      name.resize(name.size() - extension.size());
    }
    name = Printable(name);
    if (method != 0) {
      Fail(name, "is compressed, expected numpy.savez, which does not");
    }
    if (local > end || end - local < kLocalBytes) Fail(name, "is damaged");
    const size_t begin = local + kLocalBytes + Get<uint16_t>(text, local + 26) +
                         Get<uint16_t>(text, local + 28);
    if (begin > end || end - begin < size) Fail(name, "is truncated");
    all_bytes += size;
    if (all_bytes > text.size()) Fail(name, "overlaps another array");
    const std::string_view file = text.substr(begin, size);
    if (Crc32(file) != crc) Fail(name, "is damaged: its checksum differs");
    arrays_[name] = Parse(name, file);
    at += kEntryBytes + name_size + extra_size + comment_size;
  }
}

NpyArray NpzReader::Parse(const std::string& name,
                          std::string_view file) const {
  constexpr size_t kMagicBytes = 8;
  if (file.size() < kMagicBytes + 4 || file.substr(0, 6) != "\x93NUMPY") {
    Fail(name, "is no array of NumPy's");
  }
  // Version 1 has two bytes for the length of the header, later ones four.
  const bool is_first = file[6] == 1;
  const size_t length = is_first ? Get<uint16_t>(file, kMagicBytes)
                                 : Get<uint32_t>(file, kMagicBytes);
  const size_t begin = kMagicBytes + (is_first ? 2 : 4);
  if (file.size() - begin < length) Fail(name, "is truncated");
  const std::string dictionary(file.substr(begin, length));
  NpyArray array;
  array.type = Between(dictionary, "'descr': '", '\'');
  if (dictionary.find("'fortran_order': False") == std::string::npos) {
    Fail(name, "is not in C order");
  }
  const std::string shape = Between(dictionary, "'shape': (", ')');
  size_t total = 1;
  for (size_t at = 0; at < shape.size();) {
    if (shape[at] < '0' || shape[at] > '9') {
      ++at;
      continue;
    }
    size_t side = 0;
    while (at < shape.size() && shape[at] >= '0' && shape[at] <= '9') {
      side = side * 10 + static_cast<size_t>(shape[at++] - '0');
      if (side > NpzFile::kMaxBytes) Fail(name, "is too large");
    }
    array.shape.push_back(side);
    total *= side;
    if (total > NpzFile::kMaxBytes) Fail(name, "is too large");
  }
  array.bytes = file.substr(begin + length);
  size_t width = 0;
  for (size_t at = 2; at < array.type.size(); ++at) {
    const char digit = array.type[at];
    if (digit < '0' || digit > '9' || width > 1000000) {
      Fail(name, "has the type '" + Printable(array.type) + "'");
    }
    width = width * 10 + static_cast<size_t>(digit - '0');
  }
  // Elements without bytes could be as many as one likes.
  if (width == 0) Fail(name, "has the type '" + Printable(array.type) + "'");
  if (array.type.size() > 1 && array.type[1] == 'U') width *= 4;
  if (array.bytes.size() != total * width) {
    Fail(name, "has " + std::to_string(array.bytes.size()) +
                   " bytes, its shape and type need " +
                   std::to_string(total * width));
  }
  return array;
}

const NpyArray& NpzReader::At(const std::string& name,
                              size_t dimensions) const {
  const auto at = arrays_.find(name);
  if (at == arrays_.end()) Fail(name, "is missing");
  if (at->second.shape.size() != dimensions) {
    Fail(name, "has " + std::to_string(at->second.shape.size()) +
                   " dimensions, expected " + std::to_string(dimensions));
  }
  return at->second;
}

std::vector<double> NpzReader::Numbers(const std::string& name,
                                       size_t dimensions) const {
  const NpyArray& array = At(name, dimensions);
  if (array.type == "<f8") return Cast<double, double>(array.bytes);
  if (array.type == "<f4") return Cast<float, double>(array.bytes);
  std::vector<double> values;
  if (CastIntegers(array, &values)) return values;
  Fail(name, "has the type '" + Printable(array.type) + "', expected numbers");
}

std::vector<int64_t> NpzReader::Integers(const std::string& name,
                                         size_t dimensions) const {
  const NpyArray& array = At(name, dimensions);
  std::vector<int64_t> values;
  if (CastIntegers(array, &values)) return values;
  Fail(name,
       "has the type '" + Printable(array.type) + "', expected whole numbers");
}

std::vector<std::string> NpzReader::Texts(const std::string& name,
                                          size_t dimensions) const {
  const NpyArray& array = At(name, dimensions);
  if (array.type.rfind("<U", 0) != 0) {
    Fail(name, "has the type '" + Printable(array.type) + "', expected texts");
  }
  const size_t count = array.Count();
  const size_t width = count == 0 ? 0 : array.bytes.size() / count;
  std::vector<std::string> texts(count);
  for (size_t i = 0; i < count; ++i) {
    for (size_t at = 0; at < width; at += sizeof(char32_t)) {
      const auto point = Get<char32_t>(array.bytes, i * width + at);
      if (point == 0) break;
      AppendUtf8(point > 0x10FFFF ? 0xFFFD : point, &texts[i]);
    }
  }
  return texts;
}

}  // namespace kinegraph
