// A file that appears under its name only when it is complete.
#ifndef KINEGRAPH_CORE_IO_ATOMIC_FILE_H_
#define KINEGRAPH_CORE_IO_ATOMIC_FILE_H_

#include <cstdio>
#include <string>

namespace kinegraph {

// Writes beside the final name and renames in Commit(). Destroyed without
// Commit(), it leaves the final name as it was and nothing beside it. A target
// that is no regular file (/dev/stdout, a named pipe) is written directly; a
// symbolic link stays a link and its target is replaced.
//
//   AtomicFile file(path);
//   file.Write(header);
//   for (...) file.Write(line);
//   file.Commit();
class AtomicFile {
 public:
  // Throws InputError when the folder is missing or may not be written, or the
  // name is a folder's.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Buffered. Throws std::runtime_error (one line, naming the file) when the
  // system refuses, for instance on a full disk.
  void Write(const char* data, size_t size);
  void Write(const std::string& text) { Write(text.data(), text.size()); }

  // Makes the file appear. Nothing may be written afterwards.
  void Commit();

  const std::string& path() const { return path_; }

 private:
  [[noreturn]] void Fail() const;

  std::string path_;       // as the caller named it, for messages
  std::string target_;     // with symbolic links resolved
  std::string temporary_;  // empty: written directly
  std::FILE* file_ = nullptr;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_ATOMIC_FILE_H_
