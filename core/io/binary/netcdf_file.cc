#include "core/io/binary/netcdf_file.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// Numbers of the specification.
enum Tag { kDimensionTag = 10, kVariableTag = 11, kAttributeTag = 12 };
enum Type { kByte = 1, kChar = 2, kDouble = 6 };

// Most significant byte first.
template <typename Number>
void AppendBigEndian(Number number, std::string* bytes) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &number, sizeof(Number));  // of a little-endian machine
  std::reverse(raw, raw + sizeof(Number));
  bytes->append(raw, sizeof(Number));
}

void AppendPadded(const std::string& text, std::string* bytes) {
  *bytes += text;
  bytes->append((4 - text.size() % 4) % 4, '\0');
}

void AppendName(const std::string& name, std::string* bytes) {
  AppendBigEndian(static_cast<int32_t>(name.size()), bytes);
  AppendPadded(name, bytes);
}

void AppendAttribute(const std::string& name, const std::string& text,
                     std::string* bytes) {
  AppendName(name, bytes);
  AppendBigEndian(int32_t{kChar}, bytes);
  AppendName(text, bytes);  // a length and padded letters, as a name
}

// How a list begins; an empty one has no tag.
void AppendList(Tag tag, size_t count, std::string* bytes) {
  AppendBigEndian(count > 0 ? int32_t{tag} : int32_t{0}, bytes);
  AppendBigEndian(static_cast<int32_t>(count), bytes);
}

}  // namespace

int NetcdfFile::Dimension(const std::string& name, size_t length) {
  if (length > static_cast<size_t>(std::numeric_limits<int32_t>::max())) {
    throw InputError("netCDF holds at most 2^31 " + name + ", found " +
                     std::to_string(length));
  }
  dimensions_.emplace_back(name, length);
  return static_cast<int>(dimensions_.size()) - 1;
}

void NetcdfFile::Attribute(const std::string& name, const std::string& text) {
  AppendAttribute(name, text, &attributes_);
  ++attribute_count_;
}

void NetcdfFile::Attribute(const std::string& name, double number) {
  AppendName(name, &attributes_);
  AppendBigEndian(int32_t{kDouble}, &attributes_);
  AppendBigEndian(int32_t{1}, &attributes_);
  AppendBigEndian(number, &attributes_);
  ++attribute_count_;
}

void NetcdfFile::Add(const std::string& name,
                     const std::vector<int>& dimensions,
                     const Attributes& attributes, int type, size_t width,
                     std::function<void(size_t, std::string*)> append) {
  Variable variable = {name, dimensions, attributes,       type,
                       1,    width,      std::move(append)};
  for (const int dimension : dimensions) {
    variable.count *= dimensions_[static_cast<size_t>(dimension)].second;
  }
  variables_.push_back(std::move(variable));
}

void NetcdfFile::Doubles(const std::string& name,
                         const std::vector<int>& dimensions,
                         const Attributes& attributes,
                         std::function<double(size_t)> value) {
  Add(name, dimensions, attributes, kDouble, sizeof(double),
      [value = std::move(value)](size_t i, std::string* bytes) {
        AppendBigEndian(value(i), bytes);
      });
}

void NetcdfFile::Bytes(const std::string& name,
                       const std::vector<int>& dimensions,
                       const Attributes& attributes,
                       std::function<int8_t(size_t)> value) {
  Add(name, dimensions, attributes, kByte, 1,
      [value = std::move(value)](size_t i, std::string* bytes) {
        AppendBigEndian(value(i), bytes);
      });
}

void NetcdfFile::Texts(const std::string& name, int dimension,
                       const std::vector<std::string>& texts) {
  size_t width = 1;
  for (const std::string& text : texts) width = std::max(width, text.size());
  const int letters = Dimension(name + "_letters", width);
  Add(name, {dimension, letters}, {{"_Encoding", "utf-8"}}, kChar, 1,
      [texts, width](size_t i, std::string* bytes) {
        const std::string& text = texts[i / width];
        *bytes += i % width < text.size() ? text[i % width] : '\0';
      });
}

std::string NetcdfFile::Header(uint64_t first_byte) const {
  std::string header = {'C', 'D', 'F', '\x02'};
  AppendBigEndian(int32_t{0}, &header);  // no records
  AppendList(kDimensionTag, dimensions_.size(), &header);
  for (const auto& [name, length] : dimensions_) {
    AppendName(name, &header);
    AppendBigEndian(static_cast<int32_t>(length), &header);
  }
  AppendList(kAttributeTag, static_cast<size_t>(attribute_count_), &header);
  header += attributes_;
  AppendList(kVariableTag, variables_.size(), &header);
  uint64_t begin = first_byte;
  for (const Variable& variable : variables_) {
    AppendName(variable.name, &header);
    AppendBigEndian(static_cast<int32_t>(variable.dimensions.size()), &header);
    for (const int dimension : variable.dimensions) {
      AppendBigEndian(int32_t{dimension}, &header);
    }
    AppendList(kAttributeTag, variable.attributes.size(), &header);
    for (const auto& [name, text] : variable.attributes) {
      AppendAttribute(name, text, &header);
    }
    AppendBigEndian(int32_t{variable.type}, &header);
    AppendBigEndian(static_cast<uint32_t>(variable.Bytes()), &header);
    AppendBigEndian(begin, &header);
    begin += variable.Bytes();
  }
  return header;
}

void NetcdfFile::Write(const std::string& path) const {
  constexpr uint64_t kMaxBytes = 0xFFFFFFFCu;
  for (const Variable& variable : variables_) {
    if (variable.Bytes() < kMaxBytes) continue;
    throw InputError(path, "",
                     "'" + variable.name +
                         "' would have more than 4 GB, which netCDF's classic "
                         "format does not hold; take fewer frames or CSV");
  }
  AtomicFile file(path);
  file.Write(Header(Header(0).size()));
  for (const Variable& variable : variables_) {
    std::string bytes;
    constexpr size_t kPiece = 1 << 16;
    for (size_t i = 0; i < variable.count; ++i) {
      variable.append(i, &bytes);
      if (bytes.size() < kPiece) continue;
      file.Write(bytes);
      bytes.clear();
    }
    bytes.append(variable.Bytes() - variable.count * variable.width, '\0');
    file.Write(bytes);
  }
  file.Commit();
}

}  // namespace kinegraph
