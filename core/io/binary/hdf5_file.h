// Arrays of an HDF5 file. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_BINARY_HDF5_FILE_H_
#define KINEGRAPH_CORE_IO_BINARY_HDF5_FILE_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace kinegraph {

// Reads whole data sets, for ReadHdf5. Everything throws InputError naming file
// and data set; a data set that claims more than the file holds, before the
// memory is taken.
class Hdf5File {
 public:
  explicit Hdf5File(const std::string& path);
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  bool Has(const std::string& name) const;
  // Of the outermost group, sorted.
  std::vector<std::string> Names() const;
  // Empty for a single value.
  std::vector<size_t> Shape(const std::string& name) const;
  // In C order, whatever number type the file has.
  std::vector<double> Numbers(const std::string& name) const;
  // Texts of fixed or of variable length.
  std::vector<std::string> Texts(const std::string& name) const;
  // Numbers of one field of a data set of records, one record after the other;
  // each has `width` of them.
  std::vector<double> Field(const std::string& name, const std::string& field,
                            size_t* width) const;
  // The one text beside a data set; empty when there is none.
  std::string Attribute(const std::string& name,
                        const std::string& attribute) const;

 private:
  const std::string path_;
  int64_t file_ = -1;
};

// Whether the file begins as HDF5 does.
bool IsHdf5(const std::string& path);
// Names in its outermost group, sorted. Throws as ReadHdf5.
std::vector<std::string> Hdf5Names(const std::string& path);

// Debian's library can be brought down by a damaged file. So `read` is
// rehearsed in a process of its own, and done here where that went well. One
// file is read at a time, as the library asks; further threads wait. Throws
// InputError where the rehearsal ended badly, and what `read` throws.
void ReadHdf5(const std::string& path,
              const std::function<void(const Hdf5File& file)>& read);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_BINARY_HDF5_FILE_H_
