// A whole text as a file.
#ifndef KINEGRAPH_CORE_IO_FILES_WRITE_TEXT_FILE_H_
#define KINEGRAPH_CORE_IO_FILES_WRITE_TEXT_FILE_H_

#include <string>

#include "core/io/files/atomic_file.h"

namespace kinegraph {

// Throws as AtomicFile does.
inline void WriteTextFile(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_WRITE_TEXT_FILE_H_
