// Reading NumPy's .npz archives that are not compressed (numpy.savez), and .npy
// files, which are one array of no name. For core/io alone; npz_file.h names
// the sources of the format.
#ifndef KINEGRAPH_CORE_IO_BINARY_NPZ_READER_H_
#define KINEGRAPH_CORE_IO_BINARY_NPZ_READER_H_

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace kinegraph {

// One array: type as NumPy writes it ("<f8"), and its bytes in C order.
struct NpyArray {
  std::string type;
  std::vector<size_t> shape;
  std::string_view bytes;

  size_t Count() const;  // of elements
};

class NpzReader {
 public:
  // Reads the whole file. All functions throw InputError naming file and array.
  explicit NpzReader(const std::string& path);
  NpzReader(const NpzReader&) = delete;
  NpzReader& operator=(const NpzReader&) = delete;

  bool Has(const std::string& name) const { return arrays_.count(name) > 0; }
  // The array, which must be there with that many dimensions.
  const NpyArray& At(const std::string& name, size_t dimensions) const;
  // Numbers of any real type of NumPy's; whole numbers must be of one of its
  // integer types.
  std::vector<double> Numbers(const std::string& name, size_t dimensions) const;
  std::vector<int64_t> Integers(const std::string& name,
                                size_t dimensions) const;
  // Fixed-width unicode as UTF-8.
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

#endif  // KINEGRAPH_CORE_IO_BINARY_NPZ_READER_H_
