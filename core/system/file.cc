#include "core/system/file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <ctime>

namespace kinegraph {
namespace {

FileType KindOf(mode_t mode) {
  if (S_ISREG(mode)) return FileType::kRegular;
  if (S_ISDIR(mode)) return FileType::kFolder;
  return S_ISBLK(mode) ? FileType::kBlockDevice : FileType::kOther;
}

FileStatus StatusFrom(const struct stat& status) {
  return {KindOf(status.st_mode),
          status.st_size,
          {status.st_dev, status.st_ino},
          {status.st_mtim.tv_sec, status.st_mtim.tv_nsec},
          status.st_mode & 0777U};
}

bool IsNoSuchRequest(int reason) {
  return reason == EINVAL || reason == ENOSYS || reason == ENOTSUP ||
         reason == EROFS;
}

int Tolerant(int outcome) {
  return outcome != 0 && IsNoSuchRequest(errno) ? 0 : outcome;
}

// Repeats a system call that a signal interrupts.
template <typename Call>
auto Repeated(const Call& call) {
  while (true) {
    const auto outcome = call();
    if (outcome >= 0 || errno != EINTR) return outcome;
  }
}

int OpenFolder(const std::string& path) {
  return open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

}  // namespace

std::optional<FileStatus> StatusOf(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return std::nullopt;
  return StatusFrom(status);
}

std::optional<FileStatus> StatusOf(int descriptor) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0) return std::nullopt;
  return StatusFrom(status);
}

bool CanBeWritten(const std::string& path) {
  return access(path.c_str(), W_OK) == 0;
}

int OpenToRead(const std::string& path) {
  return open(path.c_str(), O_RDONLY | O_CLOEXEC);
}

int OpenToWrite(const std::string& path) {
  return open(path.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
}

int OpenNew(const std::string& path) {
  return open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
}

int Duplicate(int descriptor) { return fcntl(descriptor, F_DUPFD_CLOEXEC, 0); }

void CloseFile(int descriptor) { close(descriptor); }

std::FILE* StreamOf(int descriptor, const char* mode) {
  return fdopen(descriptor, mode);
}

int DescriptorOf(std::FILE* stream) { return fileno(stream); }

int64_t ReadSome(int descriptor, char* to, size_t size) {
  return Repeated([&] { return read(descriptor, to, size); });
}

bool SetPermissions(int descriptor, unsigned permissions) {
  return fchmod(descriptor, permissions) == 0;
}

int MakeOneFolder(const std::string& path) { return mkdir(path.c_str(), 0777); }

void RemoveFile(const std::string& path) { unlink(path.c_str()); }

void RemoveEmptyFolder(const std::string& path) { rmdir(path.c_str()); }

int SyncFile(int descriptor) {
  return Tolerant(Repeated([&] { return fsync(descriptor); }));
}

int SyncTree(const std::string& folder) {
  const int descriptor = OpenFolder(folder);
  if (descriptor < 0) return -1;
  const int outcome = Tolerant(syncfs(descriptor));
  const int reason = errno;
  close(descriptor);
  errno = reason;
  return outcome;
}

void SyncFolderOf(const std::string& path) {
  const size_t slash = path.rfind('/');
  const std::string folder =
      slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const int descriptor = OpenFolder(folder);
  if (descriptor < 0) return;
  SyncFile(descriptor);
  close(descriptor);
}

std::string FolderOfOpenFiles() {
  return "/proc/" + std::to_string(getpid()) + "/fd";
}

bool IsTerminal(int descriptor) { return isatty(descriptor) != 0; }

void PrepareStandardStreams() {
  std::signal(SIGPIPE, SIG_IGN);
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd) {
    if (fcntl(fd, F_GETFD) != -1 || errno != EBADF) continue;
    // open() returns the lowest free descriptor, which is `fd`. The mode is the
    // opposite of the stream's, so that using the stream still fails.
    const int mode = fd == STDIN_FILENO ? O_WRONLY : O_RDONLY;
    if (open("/dev/null", mode) < 0) return;
  }
}

namespace {

sigset_t OnlySigpipe() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGPIPE);
  return set;
}

}  // namespace

BrokenPipesAreErrors::BrokenPipesAreErrors() {
  const sigset_t sigpipe = OnlySigpipe();
  sigset_t before;
  pthread_sigmask(SIG_BLOCK, &sigpipe, &before);
  was_blocked_ = sigismember(&before, SIGPIPE) == 1;
}

BrokenPipesAreErrors::~BrokenPipesAreErrors() {
  if (was_blocked_) return;
  const sigset_t sigpipe = OnlySigpipe();
  // Removes a pending SIGPIPE, which unblocking would deliver.
  const timespec no_time = {0, 0};
  Repeated([&] { return sigtimedwait(&sigpipe, nullptr, &no_time); });
  pthread_sigmask(SIG_UNBLOCK, &sigpipe, nullptr);
}

bool ReaderIsGone(int descriptor) {
  pollfd stream = {descriptor, POLLOUT, 0};
  return poll(&stream, 1, 0) == 1 && (stream.revents & POLLERR) != 0;
}

bool WaitForInput(int descriptor, int stop) {
  pollfd both[2] = {{stop, POLLIN, 0}, {descriptor, POLLIN, 0}};
  return Repeated([&] { return poll(both, 2, -1); }) < 0 ||
         both[0].revents == 0;
}

bool HasInput(int descriptor, int wait_ms) {
  pollfd one = {descriptor, POLLIN, 0};
  return Repeated([&] { return poll(&one, 1, wait_ms); }) > 0;
}

bool MakePipe(int ends[2]) { return pipe2(ends, O_CLOEXEC) == 0; }

void WriteAtOnce(int descriptor, const std::string& text) {
  [[maybe_unused]] const ssize_t written =
      write(descriptor, text.data(), text.size());
}

}  // namespace kinegraph
