#include "core/io/binary/npz_file.h"

#include <zlib.h>

#include <algorithm>
#include <type_traits>

#include "core/base/error.h"
#include "core/base/utf8.h"

namespace kinegraph {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "arrays are written as little-endian numbers");

// Of what `crc` is the sum of and `bytes` behind it; 0 is that of nothing.
uint32_t ContinueCrc(uint32_t crc, std::string_view bytes) {
  if (bytes.empty()) return crc;  // zlib begins anew where there is no data
  return static_cast<uint32_t>(
      crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

template <typename Value>
void AppendLittleEndian(std::string* bytes, Value value) {
  static_assert(std::is_unsigned_v<Value>);
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

// What local header and central directory have in common, from "version
// needed" to the length of the extra field.
void AppendCommon(std::string* bytes, const std::string& name, uint32_t crc,
                  uint32_t size) {
  AppendLittleEndian<uint16_t>(bytes, 20);  // version 2.0
  AppendLittleEndian<uint16_t>(bytes, 0);   // no flags
  AppendLittleEndian<uint16_t>(bytes, 0);   // stored, not compressed
  AppendLittleEndian<uint16_t>(bytes, 0);   // time 00:00:00
  AppendLittleEndian<uint16_t>(
      bytes, 0x21);  // date 1980-01-01: same input, same bytes
  AppendLittleEndian<uint32_t>(bytes, crc);
  AppendLittleEndian<uint32_t>(bytes, size);  // compressed
  AppendLittleEndian<uint32_t>(bytes, size);  // as it is
  AppendLittleEndian<uint16_t>(bytes, static_cast<uint16_t>(name.size()));
  AppendLittleEndian<uint16_t>(bytes, 0);  // no extra field
}

std::string ShapeText(const std::vector<size_t>& shape) {
  std::string text = "(";
  for (const size_t side : shape) text += std::to_string(side) + ", ";
  if (shape.size() > 1) text.resize(text.size() - 2);
  if (shape.size() == 1) text.pop_back();
  return text + ")";
}

// Magic, version, length and a Python dictionary, padded so that the data
// begin at a multiple of 64.
std::string NpyHeader(const std::string& type,
                      const std::vector<size_t>& shape) {
  std::string dictionary =
      "{'descr': '" + type +
      "', 'fortran_order': False, 'shape': " + ShapeText(shape) + ", }";
  constexpr size_t kBefore = 10;
  constexpr size_t kAlignment = 64;
  while ((kBefore + dictionary.size() + 1) % kAlignment != 0) {
    dictionary += ' ';
  }
  dictionary += '\n';
  std::string header = "\x93NUMPY";
  header += '\x01';
  header += '\x00';
  AppendLittleEndian<uint16_t>(&header,
                               static_cast<uint16_t>(dictionary.size()));
  return header + dictionary;
}

template <typename Value>
std::string_view BytesOf(const std::vector<Value>& values) {
  return {reinterpret_cast<const char*>(values.data()),
          values.size() * sizeof(Value)};
}

// Code points of a UTF-8 text; what is none becomes U+FFFD.
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

}  // namespace

uint32_t Crc32(std::string_view bytes) { return ContinueCrc(0, bytes); }

void NpzFile::Add(const std::string& name, const std::vector<size_t>& shape,
                  const std::vector<double>& values) {
  AddBytes(name, "<f8", shape, BytesOf(values));
}
void NpzFile::Add(const std::string& name, const std::vector<size_t>& shape,
                  const std::vector<int64_t>& values) {
  AddBytes(name, "<i8", shape, BytesOf(values));
}
void NpzFile::Add(const std::string& name, const std::vector<size_t>& shape,
                  const std::vector<int32_t>& values) {
  AddBytes(name, "<i4", shape, BytesOf(values));
}
void NpzFile::Add(const std::string& name, const std::vector<size_t>& shape,
                  const std::vector<int16_t>& values) {
  AddBytes(name, "<i2", shape, BytesOf(values));
}
void NpzFile::Add(const std::string& name, const std::vector<size_t>& shape,
                  const std::vector<int8_t>& values) {
  AddBytes(name, "|i1", shape, BytesOf(values));
}

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
    row.resize(width);  // shorter texts end with zeros
    for (const char32_t point : row) {
      AppendLittleEndian<uint32_t>(&bytes, static_cast<uint32_t>(point));
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
                     "would have more than 4 GB, which this format does not "
                     "hold; take fewer frames or CSV");
  }
  Entry entry;
  entry.name = name + ".npy";
  entry.crc = ContinueCrc(ContinueCrc(0, header), bytes);
  entry.size = static_cast<uint32_t>(size);
  entry.offset = static_cast<uint32_t>(offset_);
  std::string local;
  AppendLittleEndian<uint32_t>(&local, 0x04034B50);
  AppendCommon(&local, entry.name, entry.crc, entry.size);
  local += entry.name;
  file_.Write(local);
  file_.Write(header);
  file_.Write(bytes.data(), bytes.size());
  offset_ += local.size() + size;
  entries_.push_back(std::move(entry));
}

void NpzFile::Commit() {
  std::string directory;
  for (const Entry& entry : entries_) {
    AppendLittleEndian<uint32_t>(&directory, 0x02014B50);
    AppendLittleEndian<uint16_t>(&directory, 20);  // made by version 2.0
    AppendCommon(&directory, entry.name, entry.crc, entry.size);
    AppendLittleEndian<uint16_t>(&directory, 0);  // no comment
    AppendLittleEndian<uint16_t>(&directory, 0);  // first disk
    AppendLittleEndian<uint16_t>(&directory, 0);  // internal attributes
    AppendLittleEndian<uint32_t>(&directory, 0);  // external attributes
    AppendLittleEndian<uint32_t>(&directory, entry.offset);
    directory += entry.name;
  }
  const auto count = static_cast<uint16_t>(entries_.size());
  const auto size = static_cast<uint32_t>(directory.size());
  AppendLittleEndian<uint32_t>(&directory, 0x06054B50);
  AppendLittleEndian<uint16_t>(&directory, 0);  // this disk
  AppendLittleEndian<uint16_t>(&directory, 0);  // disk of the directory
  AppendLittleEndian<uint16_t>(&directory, count);
  AppendLittleEndian<uint16_t>(&directory, count);
  AppendLittleEndian<uint32_t>(&directory, size);
  AppendLittleEndian<uint32_t>(&directory, static_cast<uint32_t>(offset_));
  AppendLittleEndian<uint16_t>(&directory, 0);  // no comment
  file_.Write(directory);
  file_.Commit();
}

}  // namespace kinegraph
