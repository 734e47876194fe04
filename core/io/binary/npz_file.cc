#include "core/io/binary/npz_file.h"

#include <zlib.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/binary/bytes.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

// Continues the checksum `crc` with `bytes`; the checksum of no data is 0.
uint32_t ContinueCrc(uint32_t crc, std::string_view bytes) {
  if (bytes.empty()) return crc;  // zlib returns 0 for a null pointer
  return static_cast<uint32_t>(
      crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

constexpr uint16_t kVersion = 20;  // of the archive: 2.0
constexpr uint16_t kNone = 0;

// Appends the fields that local header and central directory have in common,
// from "version needed" to the length of the extra field: no flags, not
// compressed, and the first second of 1980 as a fixed time, so that the same
// input gives the same bytes.
void AppendCommon(const std::string& name, uint32_t crc, uint32_t size,
                  std::string* bytes) {
  constexpr uint16_t kFirstDay = 0x21;
  AppendNumbers(bytes, kVersion, kNone, kNone, kNone, kFirstDay, crc, size,
                size, static_cast<uint16_t>(name.size()), kNone);
}

std::string ShapeText(const std::vector<size_t>& shape) {
  std::string text = "(";
  for (const size_t side : shape) text += std::to_string(side) + ", ";
  if (shape.size() > 1) text.resize(text.size() - 2);
  if (shape.size() == 1) text.pop_back();
  return text + ")";
}

// Magic, version, length and a Python dictionary, padded so that the data
// begins at a multiple of 64 bytes.
std::string NpyHeader(const std::string& type,
                      const std::vector<size_t>& shape) {
  std::string dictionary =
      "{'descr': '" + type +
      "', 'fortran_order': False, 'shape': " + ShapeText(shape) + ", }";
  constexpr size_t kBefore = 10;  // bytes before the dictionary
  constexpr size_t kAlignment = 64;
  while ((kBefore + dictionary.size() + 1) % kAlignment != 0) {
    dictionary += ' ';
  }
  dictionary += '\n';
  std::string header(kNpyMagic);
  header += '\x01';
  header += '\x00';
  AppendNumbers(&header, static_cast<uint16_t>(dictionary.size()));
  return header + dictionary;
}

// Code points of a UTF-8 text; invalid bytes become U+FFFD.
std::u32string CodePoints(const std::string& text) {
  constexpr char32_t kReplacement = 0xFFFD;
  std::u32string points;
  for (size_t i = 0; i < text.size();) {
    const Utf8Letter letter = LetterAt(text, i);
    points += letter.point.value_or(kReplacement);
    i += letter.size;
  }
  return points;
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

// The text between `begin` and `end` in the dictionary of an .npy header.
std::string Between(const std::string& dictionary, const std::string& begin,
                    char end) {
  const size_t at = dictionary.find(begin);
  if (at == std::string::npos) return "";
  const size_t from = at + begin.size();
  const size_t to = dictionary.find(end, from);
  return to == std::string::npos ? "" : dictionary.substr(from, to - from);
}

// False if the array's numbers have another type.
template <typename From, typename To>
bool CastFrom(const NpyArray& array, std::vector<To>* values) {
  if (array.type != NpyType<From>()) return false;
  values->resize(array.bytes.size() / sizeof(From));
  for (size_t i = 0; i < values->size(); ++i) {
    const From number = NumberAt<From>(array.bytes, i * sizeof(From));
    // NOLINTNEXTLINE(bugprone-signed-char-misuse): int8_t is a number here.
    (*values)[i] = static_cast<To>(number);
  }
  return true;
}

// False unless the type is one of NumPy's integers of up to 32 bits, or int64.
template <typename To>
bool CastIntegers(const NpyArray& array, std::vector<To>* values) {
  return CastFrom<int8_t>(array, values) || CastFrom<uint8_t>(array, values) ||
         CastFrom<int16_t>(array, values) ||
         CastFrom<uint16_t>(array, values) ||
         CastFrom<int32_t>(array, values) ||
         CastFrom<uint32_t>(array, values) || CastFrom<int64_t>(array, values);
}

}  // namespace

uint32_t Crc32(std::string_view bytes) { return ContinueCrc(0, bytes); }

void NpzFile::AddTexts(const std::string& name,
                       const std::vector<size_t>& shape,
                       const std::vector<std::string>& texts) {
  std::vector<std::u32string> rows;
  size_t width = 1;
  for (const std::string& text : texts) {
    rows.push_back(CodePoints(text));
    width = std::max(width, rows.back().size());
  }
  std::string bytes;
  for (std::u32string& row : rows) {
    row.resize(width);  // shorter texts are padded with zeros
    for (const char32_t point : row) {
      AppendNumbers(&bytes, static_cast<uint32_t>(point));
    }
  }
  AddBytes(name, "<U" + std::to_string(width), shape, bytes);
}

void NpzFile::AddBytes(const std::string& name, const std::string& type,
                       const std::vector<size_t>& shape,
                       std::string_view bytes) {
  const std::string header = NpyHeader(type, shape);
  const uint64_t size = header.size() + bytes.size();
  constexpr uint64_t kDirectory = 4096;  // far more than the entries need
  if (offset_ + size + kDirectory > kMaxBytes) {
    throw InputError(file_.path(), "",
                     "would exceed 4 GB, the limit of this format; write fewer "
                     "frames, or CSV");
  }
  Entry entry;
  entry.name = name + ".npy";
  entry.crc = ContinueCrc(ContinueCrc(0, header), bytes);
  entry.size = static_cast<uint32_t>(size);
  entry.offset = static_cast<uint32_t>(offset_);
  std::string local;
  AppendNumbers(&local, uint32_t{0x04034B50});
  AppendCommon(entry.name, entry.crc, entry.size, &local);
  local += entry.name;
  file_.Write(local);
  file_.Write(header);
  file_.Write(bytes.data(), bytes.size());
  offset_ += local.size() + size;
  entries_.push_back(std::move(entry));
}

void NpzFile::Commit() {
  constexpr uint32_t kNoAttributes = 0;
  std::string directory;
  for (const Entry& entry : entries_) {
    AppendNumbers(&directory, uint32_t{0x02014B50}, kVersion);
    AppendCommon(entry.name, entry.crc, entry.size, &directory);
    // No comment, first disk, no attributes.
    AppendNumbers(&directory, kNone, kNone, kNone, kNoAttributes, entry.offset);
    directory += entry.name;
  }
  const auto count = static_cast<uint16_t>(entries_.size());
  const auto size = static_cast<uint32_t>(directory.size());
  // The directory is on a single disk, number 0; no comment.
  AppendNumbers(&directory, uint32_t{0x06054B50}, kNone, kNone, count, count,
                size, static_cast<uint32_t>(offset_), kNone);
  file_.Write(directory);
  file_.Commit();
}

// ---- Reading ----

NpzReader::NpzReader(const std::string& path)
    : path_(path), text_(ReadBytes(path)) {
  if (text_.compare(0, kNpyMagic.size(), kNpyMagic) == 0) {
    arrays_[""] = Parse("", text_);
    return;
  }
  ReadDirectory();
}

void NpzReader::Fail(const std::string& name,
                     const std::string& message) const {
  throw InputError(path_, name, message);
}

// Searches backwards for the end record (section 4.3.16 of APPNOTE.TXT), which
// a comment may follow, and reads each entry of the central directory (4.3.12).
// Sizes are those in the directory; local headers (4.3.7) are only needed for
// the offset of the data.
void NpzReader::ReadDirectory() {
  constexpr size_t kEndBytes = 22;
  constexpr size_t kEntryBytes = 46;
  constexpr size_t kLocalBytes = 30;
  const std::string_view text = text_;
  const size_t end = text.rfind("PK\x05\x06");
  if (end == std::string_view::npos || text.size() - end < kEndBytes) {
    Fail("", "is not a complete .npz archive");
  }
  const auto count = NumberAt<uint16_t>(text, end + 10);
  size_t at = NumberAt<uint32_t>(text, end + 16);
  // Sum over the entries; exceeds the file's size only if entries share data.
  size_t all_bytes = 0;
  for (int i = 0; i < count; ++i) {
    if (at > end || end - at < kEntryBytes ||
        text.substr(at, 4) != "PK\x01\x02") {
      Fail("", "has a damaged directory");
    }
    const auto method = NumberAt<uint16_t>(text, at + 10);
    const auto crc = NumberAt<uint32_t>(text, at + 16);
    const size_t size = NumberAt<uint32_t>(text, at + 20);
    const size_t name_size = NumberAt<uint16_t>(text, at + 28);
    const size_t extra_size = NumberAt<uint16_t>(text, at + 30);
    const size_t comment_size = NumberAt<uint16_t>(text, at + 32);
    const size_t local = NumberAt<uint32_t>(text, at + 42);
    if (end - at < kEntryBytes + name_size) Fail("", "has a damaged directory");
    std::string name(text.substr(at + kEntryBytes, name_size));
    const std::string extension = ".npy";
    if (EndsIn(name, extension)) {
      name.resize(name.size() - extension.size());
    }
    name = Printable(name);
    if (method != 0) {
      Fail(name, "is compressed, expected an archive of numpy.savez");
    }
    if (local > end || end - local < kLocalBytes) Fail(name, "is damaged");
    const size_t begin = local + kLocalBytes +
                         NumberAt<uint16_t>(text, local + 26) +
                         NumberAt<uint16_t>(text, local + 28);
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
  constexpr size_t kMagicBytes = 8;  // version included
  if (file.size() < kMagicBytes + 4 ||
      file.substr(0, kNpyMagic.size()) != kNpyMagic) {
    Fail(name, "is not a NumPy array");
  }
  // Version 1 has two bytes for the length of the header, later ones four.
  const bool is_first = file[6] == 1;
  const size_t length = is_first ? NumberAt<uint16_t>(file, kMagicBytes)
                                 : NumberAt<uint32_t>(file, kMagicBytes);
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
  // Bytes or characters of an element; total * width then fits 64 bits.
  constexpr size_t kWidest = 10'000'000;
  size_t width = array.type.size() < 3
                     ? 0
                     : ParseNumber<size_t>(array.type.substr(2)).value_or(0);
  // A width of 0 is rejected: the bytes could not be compared with the shape.
  if (width == 0 || width > kWidest) {
    Fail(name, "has the type '" + Printable(array.type) +
                   "', expected numbers or texts");
  }
  if (array.type[1] == 'U') width *= 4;
  if (array.bytes.size() != total * width) {
    Fail(name, "has " + std::to_string(array.bytes.size()) +
                   " bytes, but its shape and type require " +
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
  std::vector<double> values;
  if (CastFrom<double>(array, &values) || CastFrom<float>(array, &values) ||
      CastIntegers(array, &values)) {
    return values;
  }
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
  const size_t count = std::accumulate(array.shape.begin(), array.shape.end(),
                                       size_t{1}, std::multiplies<size_t>());
  const size_t width = count == 0 ? 0 : array.bytes.size() / count;
  std::vector<std::string> texts(count);
  for (size_t i = 0; i < count; ++i) {
    for (size_t at = 0; at < width; at += sizeof(char32_t)) {
      const auto point = NumberAt<char32_t>(array.bytes, i * width + at);
      if (point == 0) break;
      AppendUtf8(point > 0x10FFFF ? 0xFFFD : point, &texts[i]);
    }
  }
  return texts;
}

}  // namespace kinegraph
