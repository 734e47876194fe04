// NumPy's .npz: an uncompressed zip archive of .npy arrays, written without
// either library. For core/io alone.
//
// Zip: PKWARE's APPNOTE.TXT, sections 4.3.7 (local header), 4.3.12 (central
// directory), 4.3.16 (end). Arrays: NumPy's format description, version 1.0.
#ifndef KINEGRAPH_CORE_IO_BINARY_NPZ_FILE_H_
#define KINEGRAPH_CORE_IO_BINARY_NPZ_FILE_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/files/atomic_file.h"

namespace kinegraph {

// CRC-32 of zip (reflected polynomial 0xEDB88320).
uint32_t Crc32(std::string_view bytes);

class NpzFile {
 public:
  explicit NpzFile(const std::string& path) : file_(path) {}

  // Arrays in C order; `shape` without entries is a single value. Their bytes
  // are those of this machine, which must be little-endian.
  void Add(const std::string& name, const std::vector<size_t>& shape,
           const std::vector<double>& values);
  void Add(const std::string& name, const std::vector<size_t>& shape,
           const std::vector<int64_t>& values);
  void Add(const std::string& name, const std::vector<size_t>& shape,
           const std::vector<int32_t>& values);
  void Add(const std::string& name, const std::vector<size_t>& shape,
           const std::vector<int16_t>& values);
  void Add(const std::string& name, const std::vector<size_t>& shape,
           const std::vector<int8_t>& values);
  // UTF-8 texts as fixed-width unicode.
  void AddTexts(const std::string& name, const std::vector<size_t>& shape,
                const std::vector<std::string>& texts);

  void Commit();

  // A zip archive without extensions holds less than this.
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

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_BINARY_NPZ_FILE_H_
