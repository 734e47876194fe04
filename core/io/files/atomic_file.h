// A file that appears under its name only when it is complete.
#ifndef KINEGRAPH_CORE_IO_FILES_ATOMIC_FILE_H_
#define KINEGRAPH_CORE_IO_FILES_ATOMIC_FILE_H_

#include <cstdio>
#include <string>

namespace kinegraph {

// Writes beside the final name; Commit() brings the bytes to the disk and
// renames. Destroyed without Commit(), it leaves the final name as it was and
// nothing beside it. What the name may lead to:
//   a regular file     replaced, its permissions kept; refused when it is
//                      read-only or was read by this command (input_files.h)
//   a symbolic link    stays a link; what it names is replaced or made
//   a pipe, a terminal, /dev/null, an open file (/dev/stdout, /dev/fd/3)
//                      written directly, as the bytes come
//   a folder, a block device
//                      refused
//
//   AtomicFile file(path);
//   file.Write(header);
//   for (...) file.Write(line);
//   file.Commit();
class AtomicFile {
 public:
  // Throws InputError for what is refused, and when the folder is missing or
  // may not be written.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Buffered. Throws std::runtime_error (one line, naming the file) when the
  // system refuses, for instance on a full disk.
  void Write(const char* data, size_t size);
  void Write(const std::string& text) { Write(text.data(), text.size()); }

  // Hands over what is buffered: a reader of a pipe has it then.
  void Flush();

  // Makes the file appear. Nothing may be written afterwards.
  void Commit();

  const std::string& path() const { return path_; }

 private:
  [[noreturn]] void Fail() const;
  void RefuseInput() const;

  std::string path_;       // as the caller named it, for messages
  std::string target_;     // with symbolic links resolved
  std::string temporary_;  // empty: written directly
  std::FILE* file_ = nullptr;
};

// Whether what is written to `path` arrives on standard output, where nothing
// else may then be printed.
bool IsStandardOutput(const std::string& path);

// Whether `path` leads to standard output, a pipe or a device, beside which no
// other file can stand.
bool IsStream(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_ATOMIC_FILE_H_
