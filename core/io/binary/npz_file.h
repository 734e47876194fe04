// NumPy's .npz: an uncompressed zip archive of .npy arrays, written and read
// without a library (except zlib's checksum). For core/io only, except Crc32.
//
// Zip: PKWARE's APPNOTE.TXT, sections 4.3.7 (local header), 4.3.12 (central
// directory), 4.3.16 (end). Arrays: NumPy's format description; written
// in version 1.0, read in any.
#ifndef KINEGRAPH_CORE_IO_BINARY_NPZ_FILE_H_
#define KINEGRAPH_CORE_IO_BINARY_NPZ_FILE_H_

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/io/files/atomic_file.h"

namespace kinegraph {

// The beginning of an .npy file.
inline constexpr std::string_view kNpyMagic = "\x93NUMPY";

// CRC-32 as in zip (reflected polynomial 0xEDB88320).
uint32_t Crc32(std::string_view bytes);

// NumPy's name of a number type: "<f8".
template <typename Value>
std::string NpyType() {
  static_assert(std::is_arithmetic_v<Value>);
  return std::string(sizeof(Value) == 1 ? "|" : "<") +
         (std::is_floating_point_v<Value> ? 'f'
          : std::is_signed_v<Value>       ? 'i'
                                          : 'u') +
         std::to_string(sizeof(Value));
}

class NpzFile {
 public:
  explicit NpzFile(const std::string& path) : file_(path) {}

  // Adds an array in C order; an empty `shape` means a single value. The bytes
  // are those of this machine, which must be little-endian. Add and AddTexts
  // throw InputError if the file would exceed kMaxBytes.
  template <typename Value>
  void Add(const std::string& name, const std::vector<size_t>& shape,
           const std::vector<Value>& values) {
    AddBytes(name, NpyType<Value>(), shape,
             {reinterpret_cast<const char*>(values.data()),
              values.size() * sizeof(Value)});
  }
  // Adds UTF-8 texts as fixed-width unicode.
  void AddTexts(const std::string& name, const std::vector<size_t>& shape,
                const std::vector<std::string>& texts);

  // Writes the directory and makes the file appear.
  void Commit();

  // Upper limit of a zip archive without the Zip64 extensions.
  static constexpr uint64_t kMaxBytes = 0xFFFFFFFFu;

 private:
  struct Entry {
    std::string name;
    uint32_t crc = 0;
    uint32_t size = 0;
    uint32_t offset = 0;
  };

  void AddBytes(const std::string& name, const std::string& type,
                const std::vector<size_t>& shape, std::string_view bytes);

  AtomicFile file_;
  uint64_t offset_ = 0;
  std::vector<Entry> entries_;
};

// One array: NumPy's type name ("<f8"), its shape, and its bytes in C order, a
// view into the memory of the NpzReader.
struct NpyArray {
  std::string type;
  std::vector<size_t> shape;
  std::string_view bytes;
};

// Reads uncompressed archives (numpy.savez), and .npy files as one array with
// an empty name.
class NpzReader {
 public:
  // Reads the whole file. All functions except Has throw InputError naming the
  // file and, if the error concerns one, the array.
  explicit NpzReader(const std::string& path);
  NpzReader(const NpzReader&) = delete;
  NpzReader& operator=(const NpzReader&) = delete;

  bool Has(const std::string& name) const { return arrays_.count(name) > 0; }
  // The array, which must exist with this number of dimensions.
  const NpyArray& At(const std::string& name, size_t dimensions) const;
  // Numbers accepts float64, float32 and the types that Integers accepts: int64
  // and the signed and unsigned integers of 8, 16 and 32 bits.
  std::vector<double> Numbers(const std::string& name, size_t dimensions) const;
  std::vector<int64_t> Integers(const std::string& name,
                                size_t dimensions) const;
  // Texts of fixed-width unicode, as UTF-8.
  std::vector<std::string> Texts(const std::string& name,
                                 size_t dimensions) const;

  [[noreturn]] void Fail(const std::string& name,
                         const std::string& message) const;

 private:
  void ReadDirectory();
  NpyArray Parse(const std::string& name, std::string_view file) const;

  const std::string path_;
  const std::string text_;
  std::map<std::string, NpyArray> arrays_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_BINARY_NPZ_FILE_H_
