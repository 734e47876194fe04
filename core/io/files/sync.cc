#include "core/io/files/sync.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

namespace kinegraph {
namespace {

bool IsNoSuchRequest(int reason) {
  return reason == EINVAL || reason == ENOSYS || reason == ENOTSUP ||
         reason == EROFS;
}

int Tolerant(int outcome) {
  return outcome != 0 && IsNoSuchRequest(errno) ? 0 : outcome;
}

}  // namespace

int SyncFile(int descriptor) {
  int outcome = 0;
  do {
    outcome = fsync(descriptor);
  } while (outcome != 0 && errno == EINTR);
  return Tolerant(outcome);
}

int SyncTree(const std::string& folder) {
  const int descriptor =
      open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return -1;
  const int outcome = Tolerant(syncfs(descriptor));
  const int reason = errno;
  close(descriptor);
  errno = reason;
  return outcome;
}

void SyncFolderOf(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int descriptor = open(folder.empty() ? "." : folder.c_str(),
                              O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  SyncFile(descriptor);
  close(descriptor);
}

}  // namespace kinegraph
