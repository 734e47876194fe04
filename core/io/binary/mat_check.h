// Whether a MATLAB 5 file holds as much as it declares. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_BINARY_MAT_CHECK_H_
#define KINEGRAPH_CORE_IO_BINARY_MAT_CHECK_H_

#include <string>

namespace kinegraph {

// matio takes memory for the dimensions that a file names before it looks for
// the data, and reads a truncated file silently as one with fewer entries. So
// every array is gone through first: numbers, texts, cells and structures must
// be there in the number that the dimensions say. Compressed arrays are
// unpacked, as far as their bytes may stand for it (bytes.h). Throws
// InputError naming `path`.
void CheckMatFile(const std::string& bytes, const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_BINARY_MAT_CHECK_H_
