// Recognition of formats by the beginning of a file.
#ifndef KINEGRAPH_CORE_IO_TEXT_FILE_HEAD_H_
#define KINEGRAPH_CORE_IO_TEXT_FILE_HEAD_H_

#include <string>
#include <string_view>
#include <vector>

namespace kinegraph {

struct FileHead {
  char kind = '\0';       // first character other than white space; '\0': none
  std::string beginning;  // first 64 KiB, as plain text (MakePlainText)
  // If the file is a JSON object: its outermost keys within `beginning`.
  std::vector<std::string> keys;

  bool HasKey(std::string_view key) const;
  // The cells of the first row, read as a CSV table.
  std::vector<std::string> FirstRow() const;
};
// Throws InputError naming the file if it cannot be read, is UTF-16, compressed
// by gzip, or JSON nested deeper than 256 levels.
FileHead LookAtFile(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_FILE_HEAD_H_
