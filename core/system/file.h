// Files of the operating system, by descriptor. Failures set errno.
#ifndef KINEGRAPH_CORE_SYSTEM_FILE_H_
#define KINEGRAPH_CORE_SYSTEM_FILE_H_

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

namespace kinegraph {

inline constexpr int kStandardOutput = 1;
inline constexpr int kStandardError = 2;

enum class FileType { kRegular, kFolder, kBlockDevice, kOther };

struct FileStatus {
  FileType kind = FileType::kOther;
  int64_t size = 0;  // bytes, of a regular file
  // Device and inode, which identify the file under any name.
  std::pair<uint64_t, uint64_t> number;
  std::pair<int64_t, int64_t> changed;  // contents last modified: s, ns
  unsigned permissions = 0;
};
// Links are followed.
std::optional<FileStatus> StatusOf(const std::string& path);
std::optional<FileStatus> StatusOf(int descriptor);
bool CanBeWritten(const std::string& path);

// -1 on failure. Not inherited by child programs.
int OpenToRead(const std::string& path);
// Neither creates nor truncates the file, which may be a pipe or a device.
int OpenToWrite(const std::string& path);
// Fails if the path exists, even as a link.
int OpenNew(const std::string& path);
int Duplicate(int descriptor);
void CloseFile(int descriptor);
std::FILE* StreamOf(int descriptor, const char* mode);
int DescriptorOf(std::FILE* stream);

// Owns a descriptor and closes it.
class Descriptor {
 public:
  explicit Descriptor(int opened) : value_(opened) {}
  ~Descriptor() {
    if (value_ >= 0) CloseFile(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }

 private:
  int value_;
};

// Reads available bytes. Returns their number, 0 at the end, -1 on failure.
int64_t ReadSome(int descriptor, char* to, size_t size);
bool SetPermissions(int descriptor, unsigned permissions);

// 0, or -1 on failure.
int MakeOneFolder(const std::string& path);
void RemoveFile(const std::string& path);
void RemoveEmptyFolder(const std::string& path);

// Flushes an open file to disk: 0, or -1 if data was lost; a file system that
// does not support it counts as success.
int SyncFile(int descriptor);
// Flushes the whole file system that holds a folder. Return value as for
// SyncFile; also -1 if the folder cannot be opened.
int SyncTree(const std::string& folder);
// Flushes the entry of a name in its folder. Failures are ignored.
void SyncFolderOf(const std::string& path);

// The folder that lists the open files of this process by number.
std::string FolderOfOpenFiles();

// ---- Standard streams, pipes and the terminal

bool IsTerminal(int descriptor);

// Call once, at the start. Replaces closed standard streams by streams that
// cannot be used: otherwise the next file opened would get the stream's
// descriptor, and messages would be written to it. Ignores SIGPIPE, so that a
// broken pipe does not end the program in the middle of a file.
void PrepareStandardStreams();

// For its lifetime, a write of this thread to a pipe without a reader fails
// with EPIPE and does not end the process, whatever its disposition of SIGPIPE.
class BrokenPipesAreErrors {
 public:
  BrokenPipesAreErrors();
  ~BrokenPipesAreErrors();
  BrokenPipesAreErrors(const BrokenPipesAreErrors&) = delete;
  BrokenPipesAreErrors& operator=(const BrokenPipesAreErrors&) = delete;

 private:
  bool was_blocked_ = false;
};

// Whether the reading end of a pipe is closed.
bool ReaderIsGone(int descriptor);

// Waits until one of the descriptors is readable or at its end; returns false
// if `stop` is.
bool WaitForInput(int descriptor, int stop);
// Whether data or the end of the input is available within `wait_ms`.
bool HasInput(int descriptor, int wait_ms = 0);

// Both ends, the reading end first; false on failure.
bool MakePipe(int ends[2]);
// One write without retries; what it does not write is lost.
void WriteAtOnce(int descriptor, const std::string& text);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYSTEM_FILE_H_
