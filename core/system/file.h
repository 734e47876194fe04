// Files as the operating system has them, by descriptor. What fails leaves its
// reason in errno.
#ifndef KINEGRAPH_CORE_SYSTEM_FILE_H_
#define KINEGRAPH_CORE_SYSTEM_FILE_H_

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

namespace kinegraph {

inline constexpr int kStandardInput = 0;
inline constexpr int kStandardOutput = 1;
inline constexpr int kStandardError = 2;

enum class FileType { kRegular, kFolder, kBlockDevice, kOther };

struct FileStatus {
  FileType kind = FileType::kOther;
  int64_t size = 0;  // bytes; 0 where it has none
  // Which file it is, by whatever name: of two that exist, equal for one alone.
  std::pair<uint64_t, uint64_t> number;
  std::pair<int64_t, int64_t> changed;  // s, ns
  unsigned permissions = 0;
};
// Links are followed.
std::optional<FileStatus> StatusOf(const std::string& path);
std::optional<FileStatus> StatusOf(int descriptor);
bool CanBeWritten(const std::string& path);

// -1 when the system refuses. No program that is started inherits one.
int OpenToRead(const std::string& path);
int OpenToWrite(const std::string& path);  // what is no regular file
// Fails where anything is, a link too.
int OpenNew(const std::string& path);
int Duplicate(int descriptor);
void CloseFile(int descriptor);
std::FILE* StreamOf(int descriptor, const char* mode);
int DescriptorOf(std::FILE* stream);

// Closes what it holds.
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

// Bytes that are there, 0 at the end, -1 when the system refuses.
int64_t ReadSome(int descriptor, char* to, size_t size);
bool SetPermissions(int descriptor, unsigned permissions);

// 0, or -1 when the system refuses.
int MakeOneFolder(const std::string& path);
void RemoveFile(const std::string& path);
void RemoveEmptyFolder(const std::string& path);

// Brings an open file's bytes to the disk: 0, or -1 when they were lost; a file
// system that knows no such request counts as done.
int SyncFile(int descriptor);
// Everything below a folder: its whole file system. As SyncFile.
int SyncTree(const std::string& folder);
// The entry of a name in its folder. Best effort: the name is there already.
void SyncFolderOf(const std::string& path);

// Where the open files of this process have their numbers for names.
std::string FolderOfOpenFiles();

// ---- Standard streams, pipes and the terminal

bool IsTerminal(int descriptor);

// Once, at the beginning. A standard stream that was closed by the caller would
// give its number to the next file opened, and messages would end inside a
// result: such streams become ones that fail. A reader that leaves a pipe does
// not end the program half way through a file.
void PrepareStandardStreams();

// Whether whoever read the other end of a pipe is gone.
bool ReaderIsGone(int descriptor);

// Waits until one of them has something to read or is at its end; false when it
// is `stop`.
bool WaitForInput(int descriptor, int stop);
// Whether something can be read, or the end is there, within so long.
bool HasInput(int descriptor, int wait_ms = 0);

// Both ends, the one to read first; false when the system refuses.
bool MakePipe(int ends[2]);
// Without waiting for anybody; what cannot be written is lost.
void WriteAtOnce(int descriptor, const std::string& text);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYSTEM_FILE_H_
