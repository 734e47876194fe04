// Recognition of formats by the beginning of a file.
#ifndef KINEGRAPH_CORE_IO_TEXT_FILE_HEAD_H_
#define KINEGRAPH_CORE_IO_TEXT_FILE_HEAD_H_

#include <string>
#include <string_view>
#include <vector>

namespace kinegraph {

struct FileHead {
  char kind = '\0';               // first character that is not a space
  std::string beginning;          // first 64 KiB, as plain text
  std::vector<std::string> keys;  // outermost ones of a JSON object there

  bool HasKey(std::string_view key) const;
  std::vector<std::string> FirstRow() const;  // of a table
};
// Throws InputError naming the file if it cannot be read.
FileHead LookAtFile(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_FILE_HEAD_H_
