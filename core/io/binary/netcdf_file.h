// NetCDF classic with 64-bit offsets (CDF-2), as Unidata's "NetCDF Classic
// Format Specification" has it, written without the library. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_BINARY_NETCDF_FILE_H_
#define KINEGRAPH_CORE_IO_BINARY_NETCDF_FILE_H_

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/io/files/atomic_file.h"

namespace kinegraph {

// Declares everything, then writes it at once:
//
//   NetcdfFile file;
//   const int time = file.Dimension("time", times.size());
//   file.Doubles("time", {time}, {}, [&](size_t i) { return times[i]; });
//   file.Write(path);
class NetcdfFile {
 public:
  using Attributes = std::vector<std::pair<std::string, std::string>>;

  // The index of the dimension. Throws InputError for a side of 2^31 or more.
  int Dimension(const std::string& name, size_t length);
  void Attribute(const std::string& name, const std::string& text);
  void Attribute(const std::string& name, double number);

  // Variables, in C order; `value` gives them by their place.
  void Doubles(const std::string& name, const std::vector<int>& dimensions,
               const Attributes& attributes,
               std::function<double(size_t)> value);
  void Bytes(const std::string& name, const std::vector<int>& dimensions,
             const Attributes& attributes, std::function<int8_t(size_t)> value);
  // UTF-8 texts along a dimension; they get one more for their letters.
  void Texts(const std::string& name, int dimension,
             const std::vector<std::string>& texts);

  // Throws InputError naming the file when a variable has 4 GB or more.
  void Write(const std::string& path) const;

 private:
  struct Variable {
    std::string name;
    std::vector<int> dimensions;
    Attributes attributes;
    int type = 0;
    size_t count = 0;
    size_t width = 0;  // bytes of a value
    std::function<void(size_t, std::string*)> append;
    uint64_t Bytes() const { return (count * width + 3) / 4 * 4; }
  };

  void Add(const std::string& name, const std::vector<int>& dimensions,
           const Attributes& attributes, int type, size_t width,
           std::function<void(size_t, std::string*)> append);
  std::string Header(uint64_t first_byte) const;

  std::vector<std::pair<std::string, size_t>> dimensions_;
  std::string attributes_;
  int attribute_count_ = 0;
  std::vector<Variable> variables_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_BINARY_NETCDF_FILE_H_
