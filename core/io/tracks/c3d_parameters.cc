#include "core/io/tracks/c3d_parameters.h"

#include <algorithm>
#include <cstring>

#include "core/base/error.h"

namespace kinegraph {
namespace {

constexpr size_t kMostEntries = 255;  // a side of an array is a byte

}  // namespace

BinaryText& BinaryText::Byte(int value) {
  text_ += static_cast<char>(value & 0xFF);
  return *this;
}

BinaryText& BinaryText::Word(int64_t value) {
  Byte(static_cast<int>(value & 0xFF));
  return Byte(static_cast<int>(value >> 8 & 0xFF));
}

BinaryText& BinaryText::Float(double value) {
  const auto number = static_cast<float>(value);
  uint32_t bits = 0;
  std::memcpy(&bits, &number, sizeof(bits));
  Word(bits & 0xFFFF);
  return Word(bits >> 16);
}

BinaryText& BinaryText::Text(const std::string& text) {
  text_ += text;
  return *this;
}

// Length of the name, number of the group (negative: the group itself), name,
// and the way from here to the next record, which is set when that comes.
void C3dParameters::Record(const std::string& name, int id,
                           const std::string& content) {
  BinaryText record;
  record.Byte(static_cast<int>(name.size())).Byte(id).Text(name);
  const size_t here = records_.size() + record.text().size();
  record.Word(static_cast<int64_t>(content.size() + 2)).Text(content);
  records_ += record.text();
  last_record_ = here;
}

C3dParameters& C3dParameters::Group(const std::string& name) {
  ++group_;
  Record(name, -group_, std::string(1, '\0'));  // no description
  return *this;
}

C3dParameters& C3dParameters::Add(const std::string& name, int type,
                                  const std::vector<size_t>& shape,
                                  const BinaryText& data) {
  BinaryText content;
  content.Byte(type).Byte(static_cast<int>(shape.size()));
  for (const size_t side : shape) content.Byte(static_cast<int>(side));
  content.Text(data.text()).Byte(0);  // no description
  Record(name, group_, content.text());
  return *this;
}

C3dParameters& C3dParameters::Word(const std::string& name, int64_t value) {
  return Add(name, 2, {}, BinaryText().Word(value));
}

C3dParameters& C3dParameters::Words(const std::string& name,
                                    const std::vector<int64_t>& values) {
  BinaryText data;
  for (const int64_t value : values) data.Word(value);
  return Add(name, 2, {values.size()}, data);
}

C3dParameters& C3dParameters::Float(const std::string& name, double value) {
  return Add(name, 4, {}, BinaryText().Float(value));
}

C3dParameters& C3dParameters::Floats(const std::string& name,
                                     const std::vector<size_t>& shape,
                                     const std::vector<double>& values) {
  BinaryText data;
  for (const double value : values) data.Float(value);
  return Add(name, 4, shape, data);
}

C3dParameters& C3dParameters::Texts(const std::string& name,
                                    const std::vector<std::string>& texts) {
  for (size_t begin = 0, part = 1; begin == 0 || begin < texts.size();
       begin += kMostEntries, ++part) {
    AddTexts(part == 1 ? name : name + std::to_string(part),
             texts.data() + begin,
             std::min(kMostEntries, texts.size() - begin));
  }
  return *this;
}

void C3dParameters::AddTexts(const std::string& name, const std::string* texts,
                             size_t count) {
  size_t width = 1;
  for (size_t t = 0; t < count; ++t) width = std::max(width, texts[t].size());
  width = std::min(width, kMostEntries);
  BinaryText data;
  for (size_t t = 0; t < count; ++t) {
    std::string text = texts[t];
    text.resize(width, ' ');
    data.Text(text);
  }
  Add(name, -1, {width, count}, data);
}

std::string C3dParameters::Section() const {
  constexpr size_t kMostBlocks = 255;
  std::string section(4, '\0');
  section += records_;
  // No record comes after the last.
  section[4 + last_record_] = section[4 + last_record_ + 1] = '\0';
  const size_t blocks = (section.size() + 2 + kC3dBlock - 1) / kC3dBlock;
  if (blocks > kMostBlocks) {
    throw InputError(
        "the names of all joints of all people are longer than what C3D has "
        "room for (convert one with --person=N)");
  }
  section.resize(blocks * kC3dBlock, '\0');
  section[0] = 1;
  section[1] = 0x50;
  section[2] = static_cast<char>(blocks);
  section[3] = 84;  // Intel
  return section;
}

}  // namespace kinegraph
