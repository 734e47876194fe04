// MathWorks' "MAT-File Format", chapter 1 (level 5): an element is a tag (type
// and length in bytes) and data; an array is an element made of elements.
#include "core/io/binary/mat_check.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "core/base/error.h"
#include "core/io/binary/bytes.h"

namespace kinegraph {
namespace {

// Data types and array classes that matter here.
constexpr uint32_t kInt32 = 5;
constexpr uint32_t kUint32 = 6;
constexpr uint32_t kMatrix = 14;
constexpr uint32_t kCompressed = 15;
constexpr uint32_t kComplex = 0x800;  // a flag beside the class
constexpr uint32_t kCellClass = 1;
constexpr uint32_t kStructClass = 2;
constexpr uint32_t kCharClass = 4;
constexpr uint32_t kFirstNumberClass = 6;  // double
constexpr uint32_t kLastNumberClass = 15;  // 64-bit integers

constexpr size_t kHeaderBytes = 128;
constexpr size_t kTagBytes = 8;
constexpr int kMaxDepth = 16;

// Bytes of a stored number, by data type; 0 where it is none.
size_t WidthOf(uint32_t type) {
  constexpr size_t kWidths[] = {0, 1, 1, 2, 2, 4, 4, 4, 0, 8, 0, 0, 8, 8};
  return type < std::size(kWidths) ? kWidths[type] : 0;
}

uint32_t Number(std::string_view bytes, size_t at) {
  return NumberAt<uint32_t>(bytes, at);
}

struct Element {
  uint32_t type = 0;
  std::string_view data;
};

class Checker {
 public:
  Checker(const std::string& path, size_t file_bytes)
      : path_(path), left_bytes_(MostUnpackedBytes(file_bytes)) {}

  // The elements of the file itself.
  void CheckFile(std::string_view rest) {
    while (!rest.empty()) {
      const Element element = Take(&rest, /*padded=*/false);
      if (element.type != kCompressed) {
        CheckElement(element, 0);
        continue;
      }
      const std::string unpacked = Unpack(element.data);
      std::string_view inside = unpacked;
      CheckElement(Take(&inside, /*padded=*/false), 0);
      if (!inside.empty()) Fail("holds bytes behind an array");
    }
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(path_, "", message);
  }

  // The next element of `rest`. Within an array each begins at a multiple of
  // eight bytes; one of up to four bytes may stand in its own tag.
  Element Take(std::string_view* rest, bool padded) const {
    if (rest->size() < kTagBytes) Fail("is truncated");
    Element element;
    element.type = Number(*rest, 0);
    if (element.type >> 16U != 0) {
      const size_t length = element.type >> 16U;
      element.type &= 0xFFFFU;
      if (length > 4) Fail("is damaged: a small element is too long");
      element.data = rest->substr(4, length);
      rest->remove_prefix(kTagBytes);
      return element;
    }
    const size_t length = Number(*rest, 4);
    rest->remove_prefix(kTagBytes);
    if (length > rest->size()) {
      Fail("is truncated: an element of " + std::to_string(length) +
           " bytes has only " + std::to_string(rest->size()));
    }
    element.data = rest->substr(0, length);
    const size_t step = padded ? (length + 7) / 8 * 8 : length;
    rest->remove_prefix(std::min(step, rest->size()));
    return element;
  }

  void CheckElement(const Element& element, int depth) {
    if (element.type != kMatrix) Fail("holds something that is no array");
    if (!element.data.empty()) CheckArray(element.data, depth);
  }

  void CheckArray(std::string_view rest, int depth) {
    if (depth > kMaxDepth) Fail("is nested too deeply");
    const Element flags = Take(&rest, /*padded=*/true);
    if (flags.type != kUint32 || flags.data.size() != 8) {
      Fail("has an array without flags");
    }
    const uint32_t array_class = Number(flags.data, 0) & 0xFFU;
    const uint64_t count = CountOf(Take(&rest, /*padded=*/true));
    Take(&rest, /*padded=*/true);  // its name
    if (array_class == kCellClass) return CheckArrays(count, rest, depth);
    if (array_class == kStructClass) {
      const uint64_t fields = FieldsOf(&rest);
      if (fields > 0 && count > rest.size() / fields) FailCount(count);
      return CheckArrays(count * fields, rest, depth);
    }
    const bool is_text = array_class == kCharClass;
    if (!is_text &&
        (array_class < kFirstNumberClass || array_class > kLastNumberClass)) {
      Fail("holds an array of class " + std::to_string(array_class) +
           ", expected numbers, texts, cells or structures");
    }
    if (count == 0) {
      // matio takes memory for what a tag declares here, too.
      if (!rest.empty()) Take(&rest, /*padded=*/true);
      return;
    }
    const Element numbers = Take(&rest, /*padded=*/true);
    const size_t width = is_text ? 1 : WidthOf(numbers.type);
    const bool fits = is_text
                          ? numbers.data.size() >= count
                          : width > 0 && numbers.data.size() / width == count &&
                                numbers.data.size() % width == 0;
    if (!fits) FailCount(count);
    const bool is_complex = (Number(flags.data, 0) & kComplex) != 0;
    if (is_complex) Take(&rest, /*padded=*/true);
  }

  [[noreturn]] void FailCount(uint64_t count) const {
    Fail("is truncated: an array declares " + std::to_string(count) +
         " entries, which are not there");
  }

  uint64_t CountOf(const Element& dimensions) const {
    const size_t rank = dimensions.data.size() / 4;
    if (dimensions.type != kInt32 || rank < 2 || rank > 32 ||
        dimensions.data.size() % 4 != 0) {
      Fail("has an array without dimensions");
    }
    uint64_t count = 1;
    for (size_t d = 0; d < rank; ++d) {
      const uint64_t side = Number(dimensions.data, 4 * d);
      if (side > 0x7FFFFFFFU) Fail("has an array of a negative size");
      // Beyond 2^32 no file of this kind holds it.
      count = std::min<uint64_t>(count * side, uint64_t{1} << 32U);
    }
    return count;
  }

  // A structure names the bytes of a field's name, then the names.
  uint64_t FieldsOf(std::string_view* rest) const {
    const Element length = Take(rest, /*padded=*/true);
    if (length.type != kInt32 || length.data.size() != 4 ||
        Number(length.data, 0) == 0) {
      Fail("has a structure without names");
    }
    return Take(rest, /*padded=*/true).data.size() / Number(length.data, 0);
  }

  void CheckArrays(uint64_t count, std::string_view rest, int depth) {
    if (count > rest.size() / kTagBytes) FailCount(count);
    for (uint64_t i = 0; i < count; ++i) {
      CheckElement(Take(&rest, /*padded=*/true), depth + 1);
    }
  }

  // An element with its tag, which says first how long it is.
  std::string Unpack(std::string_view packed) {
    z_stream stream{};
    if (inflateInit(&stream) != Z_OK) Fail("cannot be unpacked");
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    std::string unpacked(kTagBytes, '\0');
    const auto inflate_at = [&](size_t at) {
      stream.next_out = reinterpret_cast<Bytef*>(unpacked.data() + at);
      stream.avail_out = static_cast<uInt>(unpacked.size() - at);
      return inflate(&stream, Z_NO_FLUSH);
    };
    int state = inflate_at(0);
    const size_t length = Number(unpacked, 4);
    const bool fits = length <= left_bytes_;
    if (fits && state == Z_OK) {
      left_bytes_ -= length;
      unpacked.resize(kTagBytes + length + 1);  // one more shows the end
      state = inflate_at(kTagBytes);
    }
    inflateEnd(&stream);
    if (!fits) {
      Fail("would unpack to " + std::to_string(length) +
           " bytes, too many for what is stored");
    }
    if (state != Z_STREAM_END) Fail("is truncated or damaged");
    unpacked.resize(unpacked.size() - stream.avail_out);
    return unpacked;
  }

  const std::string path_;
  size_t left_bytes_;  // that may be unpacked
};

}  // namespace

void CheckMatFile(const std::string& bytes, const std::string& path) {
  if (bytes.size() < kHeaderBytes || bytes.compare(0, 10, "MATLAB 5.0") != 0) {
    throw InputError(path, "", "is no MATLAB 5 file");
  }
  if (bytes.compare(126, 2, "IM") != 0) {
    throw InputError(path, "", "is not little-endian, expected that");
  }
  if (bytes.size() == kHeaderBytes) throw InputError(path, "", "is truncated");
  Checker(path, bytes.size())
      .CheckFile(std::string_view(bytes).substr(kHeaderBytes));
}

}  // namespace kinegraph
